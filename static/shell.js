// The frame around the scene: its bar says what is looked at, what the robot does, and stops it.
// It goes to the login when the login has ended, comes back when the server does, and is light or
// dark as the scene is.
"use strict";

const RETRY_MS = 1000;
const OVER = 4401;  // close code: the login has ended

const SILENT_MS = 6000;  // the server says something every 2 s: after this it is out of reach

const LOOK_MS = 200;  // between two looks at what the scene says of itself
const SCHEME = "workbench-scheme";  // cookie: the page is light or dark

const PANEL = "workbench-panel";    // cookie: how wide the controls are
const TOUCH = "workbench-touch";    // cookie: controls are large, whatever the pointer is
const MOTION = "workbench-motion";  // cookie: the system asks for less motion

const LOOKS = 4;      // in a row: what comes with the next message is not gone yet
const AWAY = word("No connection: Stop may not reach the robot. Trying again.");

const NOT_STOPPED = `${word("Not stopped:")} `;

const stop = document.getElementById("stop");
const line = document.getElementById("link");
const scene = document.getElementById("scene");
const touch = document.getElementById("touch");

const LOGOUT = document.getElementById("leave-page");

const SILENT = word("the server does not answer. Use the emergency stop.");

let presence = null;  // the websocket that the bar hears by
let stops = [];       // what is done when it answers a stop, in the order of asking
let presses = 0;      // of Stop
let isHere = false;   // whether what the bar says is news
let hasRobot = true;  // until the server says otherwise
let unseen = 0;       // looks in a row at which the searches that are compared were out of sight
let width = 0;        // of the controls at the last look
let stood = "";       // what the robot did when the bar was last told of it

function leave() {
  // Without what is on screen: whoever comes next may be somebody else.
  scene.remove();
  location.replace("/login");
}

async function again() {
  try {
    const signal = AbortSignal.timeout(SILENT_MS);
    const answer = await fetch("/who", { cache: "no-store", signal });
    if (answer.status === 401) {
      leave();
      return;
    }
    if (answer.ok) {
      const who = await answer.json();
      const shown = document.querySelector(".role").dataset.role;
      if (who.name !== document.getElementById("name").textContent || who.role !== shown) {
        location.reload();
        return;
      }
      stay();
      return;
    }
  } catch {
    // Nobody answers: the server is away for now.
  }
  setTimeout(again, RETRY_MS);
}

function stay() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  stops = [];  // what was asked before, nobody answers
  const socket = presence = new WebSocket(`${scheme}//${location.host}/presence`);
  let late = setTimeout(gone, SILENT_MS);
  // A cut cable closes nothing: silence ends it, and what is said later does not count.
  let isOver = false;
  function gone() {
    if (isOver) return;
    isOver = true;
    clearTimeout(late);
    socket.close();
    away();
    setTimeout(again, RETRY_MS);
  }
  socket.onmessage = (event) => {
    if (isOver) return;
    clearTimeout(late);
    late = setTimeout(gone, SILENT_MS);
    isHere = true;
    if (line.textContent === AWAY) line.textContent = "";
    const said = JSON.parse(event.data);
    if ("stopped" in said) stops.shift()?.(said);
    else say(said);
  };
  socket.onclose = (event) => {
    if (event.code === OVER) leave();
    else gone();
  };
}

function away() {
  isHere = false;
  line.textContent = AWAY;
  put("robot", "", "off");
  put("mode", "", "off");
  // Nobody knows whether the robot moves: it may be tried.
  stop.hidden = stop.disabled = !hasRobot;
}

function put(name, text, kind) {
  const place = document.getElementById(name);
  if (place.textContent !== text) place.textContent = text;
  place.title = text;
  place.dataset.kind = kind;
}

function say(bar) {
  document.dispatchEvent(new CustomEvent("bar", { detail: bar }));
  put("robot", bar.robot, bar.kind);
  put("fault", bar.fault ? `${word("Fault:")} ${bar.fault}` : "", "bad");
  // What was said of a stop belongs to that sending, or to the robot as it stood then.
  const stands = bar.can_stop ? "can be stopped" : bar.robot;
  if (stands !== stood && line.textContent.startsWith(NOT_STOPPED)) line.textContent = "";
  stood = stands;
  hasRobot = bar.has_robot;
  stop.hidden = !hasRobot;
  stop.disabled = !bar.can_stop;
  // The page comes anew in another language, and the stop would be away meanwhile.
  LANGUAGE.disabled = bar.can_stop;
  // Whoever leaves while the robot moves has no Stop any more.
  const out = LOGOUT.querySelector("button");
  out.disabled = bar.can_stop;
  out.title = bar.can_stop ? word("The robot moves: stop it, or wait until it stands.") : "";
  stop.title = bar.can_stop
    ? word("Asks the controller to stop and closes the link. Not a safety function: in danger use the emergency stop.")
    : bar.why;
}

async function halt() {
  // Not by the scene: it may hang.  And by two ways at once: on a poor network one is late.
  const own = ++presses;
  line.textContent = word("Stopping");
  const ways = [stopByRequest(), stopByPresence()];
  let says = "";
  try {
    await Promise.any(ways);
  } catch (none) {
    // An answer says more than that there was none.
    const why = none.errors.map((error) => error.message).find((text) => text !== SILENT);
    says = NOT_STOPPED + (why ?? SILENT);
  }
  // What came of the last press counts, and the bar may be cut off nevertheless.
  if (own === presses) line.textContent = says || (isHere ? "" : AWAY);
}

async function stopByRequest() {
  let answer;
  try {
    answer = await fetch("/api/v1/stop", { method: "POST", signal: AbortSignal.timeout(SILENT_MS) });
  } catch {
    throw new Error(SILENT);
  }
  if (!answer.ok) throw new Error(detail(await answer.text()));
}

function stopByPresence() {
  return new Promise((resolve, reject) => {
    if (presence?.readyState !== WebSocket.OPEN) {
      reject(new Error(SILENT));
      return;
    }
    stops.push((said) => (said.stopped ? resolve() : reject(new Error(said.why))));
    setTimeout(() => reject(new Error(SILENT)), SILENT_MS);
    presence.send("stop");
  });
}

function detail(text) {
  try {
    return JSON.parse(text).detail;
  } catch {
    return text.trim();
  }
}

function compare(page) {
  // Parts of another search are drawn for all only while whoever compares them sees the table.
  const marked = page.querySelector(".wb-compares");
  const isOver = marked && !page.querySelector(".wb-searches")?.checkVisibility();
  unseen = isOver ? unseen + 1 : 0;
  if (unseen === LOOKS) page.getElementById(marked.dataset.ends)?.click();
}

function keepWidth(page) {
  // Whoever has pulled them wider or narrower finds them so next time; not where they fill the window.
  const panel = page.querySelector(".mantine-ScrollArea-root:has(.wb-head)");
  const now = Math.round(panel?.getBoundingClientRect().width ?? 0);
  const isPulled = width > 0 && now > 0 && now !== width && innerWidth === page.defaultView.innerWidth;
  if (isPulled && innerWidth > 768) remember(PANEL, now);
  width = now;
}

function remember(name, value) {
  document.cookie = `${name}=${value}; path=/; max-age=31536000; samesite=strict`;
}

function look() {
  // The mode is the scene's: what one moves by hand there, only that page knows.
  const shown = scene.contentDocument?.querySelector(".wb-mode");
  if (shown) {
    if (isHere) put("mode", shown.querySelector("b").textContent, shown.dataset.mode);
    if (!document.getElementById("wait").hidden) {
      document.getElementById("wait").hidden = true;
      takeScheme();
    }
    compare(scene.contentDocument);
    keepWidth(scene.contentDocument);
  }
}

function takeScheme() {
  const scheme = scene.contentDocument?.documentElement.getAttribute("data-mantine-color-scheme");
  // Until it is drawn, the scene is light for everybody.
  if (!scheme || !document.getElementById("wait").hidden) return;
  document.documentElement.dataset.scheme = scheme;
  // The server makes the next page of this browser alike.
  remember(SCHEME, scheme);
}

function enlarge(isWanted) {
  for (const page of [document, scene.contentDocument]) {
    page?.documentElement?.toggleAttribute("data-touch", isWanted);
  }
  touch.setAttribute("aria-pressed", isWanted);
}

function cookie(name) {
  return document.cookie.split("; ").find((one) => one.startsWith(`${name}=`))?.split("=")[1];
}

function isLarge() {
  // Until its person has chosen: as the pointer wants it.
  const wanted = cookie(TOUCH);
  return wanted ? wanted === "large" : matchMedia("(pointer: coarse)").matches;
}

function follow() {
  const root = scene.contentDocument?.documentElement;
  if (!root) return;
  root.lang = document.documentElement.lang;
  enlarge(isLarge());
  new MutationObserver(takeScheme).observe(root, { attributes: true });
  scene.contentWindow.focus();
}

// Until the scene says how it looks: as it was last, or as the system wants it.
const chosen = cookie(SCHEME);
if (chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches) {
  document.documentElement.dataset.scheme = "dark";
  document.cookie = `${SCHEME}=dark; path=/; samesite=strict`;
}
remember(MOTION, matchMedia("(prefers-reduced-motion: reduce)").matches ? "less" : "full");
enlarge(isLarge());
touch.addEventListener("click", () => {
  remember(TOUCH, isLarge() ? "small" : "large");
  enlarge(isLarge());
});
stop.addEventListener("click", halt);
LOGOUT.addEventListener("submit", (event) => {
  const asks = word("The link of the start opens the page once, and nobody has a password: whoever logs out comes back by a new start. Log out?");
  if (LOGOUT.dataset.returns === "false" && !confirm(asks)) event.preventDefault();
});
setInterval(look, LOOK_MS);
scene.addEventListener("load", follow);
if (scene.contentDocument?.readyState === "complete") follow();
stay();
