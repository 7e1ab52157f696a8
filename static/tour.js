// The tour: leads through one pick on a simulated cell.  It points at what is to be pressed,
// presses nothing itself, and goes on when the server says that the thing was done; what is only
// looked at, the scene's page knows.  Whoever has ended or left it once is not asked again in this
// browser.

const KEPT = "workbench-tour";

const LOOK_MS = 200;  // between two looks at where things are

const GAP = 16;       // pixels between the card and what it stands beside

const EDGE = 8;       // and to the edge of the window

const LEGEND = 96;    // below the legend, where there is no room beside it

const WIDE = 560;     // the card lies flat over the top of the scene, at most so wide
const NARROW = 304;   // and at least

// Buttons that say a number or a name beside: known by what stands before it.
const RUN = beginning("Run step {waits} of {steps}: {words}");
const APPROVE = beginning("Approve as {name}{how}");

const STEPS = [
  { name: "scan", title: word("Scan"), on: word("Cycle"), press: [word("Scan")],
    says: word("Parts fall into the simulated bin, and the scanner looks at them from above. Press Scan.") },
  { name: "find", title: word("Find the parts"), on: word("Cycle"), press: [word("Find parts")],
    says: word("The workbench searches the scan for the part's shape. Press Find parts. If none is found, choose "
      + "another seed and scan again.") },
  { name: "grasps", title: word("Look at the grasps"), on: word("Grasps"), press: [word("Back to cell"), word("Edit grasps")],
    isLook: true, says: word("A grasp is where a hand closes on the part. In the tab Grasps press Edit grasps to see "
      + "the grasps, then Back to cell.") },
  { name: "plan", title: word("Plan"), on: word("Cycle"), press: [word("Plan")],
    says: word("Open the tab Cycle and press the button Plan in group 3. Every grasp is tested with each arm, the "
      + "motion is planned, and a second, independent program checks it. If no plan comes out, scan another seed.") },
  { name: "judge", title: word("See why grasps fail"), on: word("Candidates"), isLook: true, isAside: true,
    rows: [".wb-rows .wb-table tbody .wb-refused", ".wb-rows .wb-table tbody tr"],
    says: word("The tab Candidates lists each grasp with its verdict. Click a row that was refused: the scene shows "
      + "the hand there, and what it would hit in red.") },
  { name: "preview", title: word("Watch the preview"), on: word("Cycle"), press: [word("Pause"), word("Play")],
    isAside: true, says: word("Open the tab Cycle, press Play, and watch the see-through robot to the end. Nothing "
      + "is sent. You can approve only what you have watched.") },
  { name: "approve", title: word("Approve"), on: word("Cycle"), press: [word("Approve")], dialog: APPROVE,
    says: word("Press Approve, read the figures of the plan, type your name, and press the button with your name. "
      + "The approval holds for this plan and for one sending.") },
  { name: "send", title: word("Send"), on: word("Cycle"), press: [RUN, word("Send")], isAside: true,
    says: word("Press Send, and the simulated robot moves. While it moves, Stop is red at the top right, whichever "
      + "tab is open, and ends the motion.") },
];

const FAULT = { title: word("A fault came up"), press: [word("Acknowledge")],
  says: word("The bar says what it is. With a real robot you would go to the cell now. Press Acknowledge; "
    + "a pick then begins with a new scan.") };

const ASKED = { title: word("Is this your first visit?"),
  says: word("A tour leads through one pick on the simulated cell: from the scan to the robot that moves. You press "
    + "everything yourself, and leave when you like. Press T to move the focus here.") };

const OVER = { title: word("That was a pick"), isAside: true,
  says: word("If a pick failed, report it in the tab Cycle, under Result of each pick. Next cycle, below Scan, begins "
    + "the next pick. Tour, in the bar above, shows these steps again.") };

// The bar under the scene has a Play, too: the steps speak of the one in the tab.
const UNDER_SCENE = ".mantine-Paper-root:has(> div > div > div > div > .wb-transport)";

const at = (id) => document.getElementById(id);
const [card, ring, call, go, leave, scene] = ["card", "ring", "tour", "go", "leave", "scene"].map(at);

let bar = null;        // what the bar was told last
let stands = "away";   // away, asked, on or over
let isBefore = false;  // a pick that ended before the tour began is not the one of the tour
let seen = new Set();  // what was looked at
let isOpen = false;    // the part stood alone, with its grasps
let shown = null;      // the element that was pointed at last
let isHeld = false;    // a button of the card is pressed and not let go of yet

function beginning(text) {
  const before = word(text).split("{")[0].replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
  return new RegExp(`^${before}`);
}

function kept() {
  try {
    return localStorage.getItem(KEPT) !== null;
  } catch {
    return true;  // a browser that keeps nothing would ask each time
  }
}

function keep() {
  try {
    localStorage.setItem(KEPT, "over");
  } catch {
    // It asks nobody then, see `kept`.
  }
}

function begin() {
  stands = "on";
  isBefore = bar.tour.includes("send");
  seen = new Set();
  isOpen = false;
}

function end() {
  // The keyboard goes to the scene, unless it was there anyway.
  if (card.contains(document.activeElement)) scene.contentWindow.focus();
  stands = "away";
  keep();
  draw();
}

function isThere(element) {
  return element.getClientRects().length > 0;
}

function all(selector) {
  return [...scene.contentDocument.querySelectorAll(selector)].filter(isThere);
}

function button(says, within = 'button:not([role="tab"])') {
  const is = typeof says === "string" ? (text) => text === says : (text) => says.test(text);
  return all(within).find((one) => is(one.textContent.trim()) && !one.closest(UNDER_SCENE));
}

function dialog() {
  return all('[role="dialog"]')[0];
}

function control(step) {
  // The tab, while what is in it is not shown.
  const within = dialog() && step.dialog;
  const pressed = (step.press ?? []).map((one) => button(one)).find(Boolean);
  return (within && (button(step.dialog, '[role="dialog"] button') || all('[role="dialog"] input')[0]))
    || rows(step)[0] || pressed || button(step.on, '[role="tab"]') || null;
}

function rows(step) {
  // Those it speaks of, or any where there are none of these.
  return (step.rows ?? []).map((selector) => all(selector)).find((found) => found.length) ?? [];
}

function look(step) {
  // What only this page sees: that the part was opened and left, that a row was chosen.
  if (step.name === "grasps") {
    if (button(word("Back to cell"))) isOpen = true;
    else if (isOpen) seen.add(step.name);
  }
  const isChosen = scene.contentDocument.querySelector(".wb-row-chosen");
  if (step.name === "judge" && isChosen && rows(step).length) seen.add(step.name);
}

function isDone(step) {
  if (isBefore) return false;
  return bar.tour.includes(step.name) || (step.isLook && (seen.has(step.name) || bar.tour.includes("approve")));
}

function offered() {
  // Some tabs are not everybody's.
  return STEPS.filter((step) => !step.isLook || button(step.on, '[role="tab"]'));
}

function current() {
  if (bar.fault) return FAULT;
  if (!bar.tour.includes("send")) isBefore = false;
  const step = offered().find((one) => !isDone(one));
  if (!step) return OVER;
  if (step.isLook) look(step);
  return step;
}

function put(id, text) {
  // Only what is new, or it would be read aloud again and again.
  if (at(id).textContent !== text) at(id).textContent = text;
}

function draw() {
  call.hidden = !bar?.tour;
  const isReady = bar?.tour && at("wait").hidden && scene.contentDocument?.querySelector(".wb-strip");
  if (isReady && stands === "away" && !kept()) stands = "asked";
  card.hidden = !isReady || stands === "away";
  if (card.hidden) {
    ring.hidden = true;
    return;
  }
  const step = stands === "asked" ? ASKED : stands === "over" ? OVER : current();
  if (step === OVER && stands === "on") {
    stands = "over";
    keep();
  }
  const steps = offered();
  const number = steps.indexOf(step) + 1;
  put("count", number ? word("Step {number} of {count}", { number, count: steps.length }) : "");
  put("title", step.title);
  put("says", step.says);
  const target = step.press || step.rows ? control(step) : null;
  put("go", step === ASKED ? word("Begin") : word("Show me"));
  put("leave", step === ASKED ? word("Not now") : step === OVER ? word("Close") : word("Leave the tour"));
  go.hidden = step === OVER;
  // What is greyed out takes no focus: its time has not come yet.
  go.disabled = step !== ASKED && (!target || target.disabled === true);
  if (target !== shown) target?.scrollIntoView({ block: "nearest" });
  shown = target;
  // A button that moves away from under the pointer gets no click.
  if (!isHeld) place(target, step.isAside);
}

function place(target, isAside) {
  const frame = scene.getBoundingClientRect();
  const box = target?.getBoundingClientRect();
  const ringed = box && box.bottom > 0 && box.top < frame.height;
  ring.hidden = !ringed;
  if (ringed) {
    set(ring, { left: frame.left + box.left - 5, top: frame.top + box.top - 5,
      width: box.width + 10, height: box.height + 10 });
  }
  // Beside the controls and an open dialog, never over them, and below the bar.
  const beside = [scene.contentDocument.querySelector(".wb-strip"), dialog()].filter(Boolean)
    .map((one) => one.getBoundingClientRect());
  const left = frame.left + Math.min(...beside.map((one) => one.left)) - GAP - card.offsetWidth;
  const right = frame.left + Math.max(...beside.map((one) => one.right)) + GAP;
  const isFlat = isAside && !dialog() && layFlat(frame);
  if (!isFlat) card.style.removeProperty("width");
  card.dataset.flat = isFlat;
  if (isFlat) {
    card.dataset.side = "none";
    return;
  }
  const fits = isAside && !dialog() ? "none" : left >= EDGE ? "left" : right + card.offsetWidth <= frame.right - EDGE ? "right" : "none";
  card.dataset.side = ringed ? fits : "none";
  const middle = frame.top + (box ? box.top + box.height / 2 : card.offsetHeight / 2 + 4 * GAP);
  const lowest = frame.bottom - EDGE - card.offsetHeight;
  const top = Math.max(frame.top + EDGE, Math.min(middle - card.offsetHeight / 2, lowest));
  set(card, { left: fits === "left" ? left : fits === "right" ? right : frame.left + EDGE,
    top: fits === "none" ? frame.top + LEGEND : top });
  card.style.setProperty("--at", `${middle - top - 2}px`);
}

function layFlat(frame) {
  // What the step speaks of is in the scene: the card lies over its sky, between legend and controls.
  const legend = all(".wb-mode")[0]?.getBoundingClientRect();
  const begins = frame.left + (legend ? legend.right : 0) + GAP;
  const ends = frame.left + all(".wb-strip")[0].getBoundingClientRect().left - GAP;
  const width = Math.min(WIDE, ends - begins);
  if (width < NARROW) return false;
  set(card, { left: ends - width, top: frame.top + EDGE, width });
  return true;
}

function set(element, places) {
  for (const [name, pixels] of Object.entries(places)) element.style[name] = `${Math.round(pixels)}px`;
}

function typed(event) {
  const isField = event.target.closest?.("input, textarea, select, [contenteditable=true]");
  if (event.key.toLowerCase() !== "t" || event.ctrlKey || event.altKey || event.metaKey || isField) return;
  if (!bar?.tour || dialog()) return;
  if (stands === "away") begin();
  draw();
  (go.hidden || go.disabled ? leave : go).focus();
}

call.addEventListener("click", () => {
  begin();
  draw();
});
go.addEventListener("click", () => {
  if (stands === "asked") begin();
  else {
    // What was pointed at last may have been made anew since.
    draw();
    scene.contentWindow.focus();
    shown?.focus();
    ring.animate({ transform: ["scale(1)", "scale(1.15)", "scale(1)"] }, { duration: 300, iterations: 2 });
  }
  draw();
});
leave.addEventListener("click", end);
card.addEventListener("keydown", (event) => event.key === "Escape" && end());
card.addEventListener("pointerdown", () => { isHeld = true; });
for (const name of ["pointerup", "pointercancel", "blur"]) addEventListener(name, () => { isHeld = false; });
document.addEventListener("keydown", typed);
const listen = () => scene.contentDocument?.addEventListener("keydown", typed);
scene.addEventListener("load", listen);
listen();
document.addEventListener("bar", (event) => {
  bar = event.detail;
  draw();
});
setInterval(draw, LOOK_MS);
