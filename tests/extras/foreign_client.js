// A client of another make: node-opcua.  It is told what to do as JSON and answers with JSON.
const fs = require("fs");
const opcua = require("node-opcua-client");
// It comes with the client, wherever npm has put it.
const { OPCUACertificateManager } = require(require.resolve("node-opcua-certificate-manager",
  { paths: [require.resolve("node-opcua-client")] }));

const ATTRIBUTES = ["BrowseName", "NodeClass", "DataType", "Value"];

async function everything(session, node, path, found) {
  const uris = await session.readNamespaceArray();
  const told = (id) => `${uris[id.namespace]}|${id.value}`;
  const all = opcua.BrowseDirection.Forward;
  const seen = async (id, names) => {
    const browsed = await session.browse({
      nodeId: id, browseDirection: all, includeSubtypes: true, resultMask: 63,
      referenceTypeId: "i=31", nodeClassMask: 0,
    });
    const values = await session.read(
      ATTRIBUTES.map((name) => ({ nodeId: id, attributeId: opcua.AttributeIds[name] })));
    const one = { path: names, id: told(id), references: [] };
    one.nodeClass = values[1].value.value;
    if (one.nodeClass === 2) {
      one.dataType = told(values[2].value.value);
      one.status = values[3].statusCode.name;
      const value = values[3].value ? values[3].value.value : null;
      one.value = value && value.toJSON ? value.toJSON() : value;
    }
    found.push(one);
    for (const reference of browsed.references) {
      const to = told(reference.nodeId);
      const by = told(reference.referenceTypeId);
      if (by === "http://opcfoundation.org/UA/|40") one.type = to;
      else one.references.push({ by, to });
      const owned = ["46", "47"].some((number) => by === `http://opcfoundation.org/UA/|${number}`);
      const name = `${uris[reference.browseName.namespaceIndex]}|${reference.browseName.name}`;
      if (owned) await seen(reference.nodeId, [...names, name]);
    }
  };
  await seen(node, path);
}

async function ofCell(session) {
  const objects = await session.browse("ns=0;i=85");
  const cell = objects.references.find((one) => one.browseName.name === "Workbench").nodeId;
  return { cell, members: (await session.browse(cell)).references };
}

const TASKS = {
  async tree(session, task) {
    const found = [];
    await everything(session, opcua.resolveNodeId(task.node), [], found);
    return found;
  },
  async read(session, task) {
    const values = await session.read(task.nodes.flatMap((nodeId) =>
      ATTRIBUTES.slice(0, 3).map((name) => ({ nodeId, attributeId: opcua.AttributeIds[name] }))));
    return task.nodes.map((node, k) => {
      const [name, kind, type] = values.slice(3 * k, 3 * k + 3);
      const isThere = name.statusCode.isGood();
      return isThere && {
        name: name.value.value.name, space: name.value.value.namespaceIndex,
        nodeClass: kind.value.value, dataType: type.value?.value ? String(type.value.value) : "",
      };
    });
  },
  async namespaces(session) { return await session.readNamespaceArray(); },
  async changes(session, task) {
    const values = [];
    const subscription = await session.createSubscription2({
      requestedPublishingInterval: 50, requestedLifetimeCount: 1000,
      requestedMaxKeepAliveCount: 10, publishingEnabled: true,
    });
    const item = await subscription.monitor(
      { nodeId: task.node, attributeId: opcua.AttributeIds.Value },
      { samplingInterval: 50, queueSize: 100, discardOldest: true }, opcua.TimestampsToReturn.Both);
    await new Promise((resolve) => item.on("changed", (value) => {
      values.push({ value: value.value?.value ?? null, status: value.statusCode.name });
      if (values.length === 1) console.error("listening");
      if (values.length >= task.count) resolve();
    }));
    await subscription.terminate();
    return values;
  },
  async values(session) {
    const { members } = await ofCell(session);
    const variables = members.filter((one) => one.nodeClass === 2);
    const values = await session.read(variables.map((one) => ({
      nodeId: one.nodeId, attributeId: opcua.AttributeIds.Value })));
    return Object.fromEntries(variables.map((one, k) => [one.browseName.name,
      { value: values[k].value.value, type: opcua.DataType[values[k].value.dataType] }]));
  },
  async call(session, task) {
    const { cell, members } = await ofCell(session);
    const method = members.find((one) => one.browseName.name === task.method).nodeId;
    const given = (task.arguments || []).map(([type, value]) => (
      { dataType: opcua.DataType[type], value }));
    const answer = await session.call({ objectId: cell, methodId: method, inputArguments: given });
    return { status: answer.statusCode.name,
      said: (answer.outputArguments || []).map((one) => one.value) };
  },
};

async function main() {
  const told = JSON.parse(process.argv[2]);
  const manager = told.pki && new OPCUACertificateManager({
    rootFolder: told.pki, automaticallyAcceptUnknownCertificate: true });
  if (manager) {
    await manager.initialize();
    if (!fs.existsSync(told.certificate)) {
      await manager.createSelfSignedCertificate({
        applicationUri: told.uri, subject: "CN=foreign", dns: ["localhost"], ip: ["127.0.0.1"],
        startDate: new Date(), validity: 365, outputFile: told.certificate });
    }
  }
  const client = opcua.OPCUAClient.create({
    applicationUri: told.uri, applicationName: "foreign", endpointMustExist: false,
    connectionStrategy: { maxRetry: 0, initialDelay: 100 }, transportTimeout: 20000,
    securityMode: opcua.MessageSecurityMode[told.mode || "None"],
    securityPolicy: opcua.SecurityPolicy[told.policy || "None"],
    ...(manager ? { clientCertificateManager: manager, certificateFile: told.certificate,
      privateKeyFile: manager.privateKey } : {}),
  });
  await client.connect(told.url);
  const endpoints = (await client.getEndpoints()).map((one) => ({
    policy: one.securityPolicyUri.split("#")[1], mode: opcua.MessageSecurityMode[one.securityMode] }));
  const session = await client.createSession(told.user ? {
    type: opcua.UserTokenType.UserName, userName: told.user, password: told.password,
  } : undefined);
  const answers = [];
  for (const task of told.tasks) answers.push(await TASKS[task.what](session, task));
  await session.close();
  await client.disconnect();
  if (manager) await manager.dispose();
  return { endpoints, answers };
}

main().then((answer) => {
  process.stdout.write(`\n@@${JSON.stringify(answer)}\n`, () => process.exit(0));
}, (error) => {
  process.stdout.write(`\n@@${JSON.stringify({ error: String(error.message) })}\n`,
    () => process.exit(1));
});
