// What the scene's page needs beside what viser gives it.  For keyboards and screen readers: headings
// of groups that open, names of what has none, and lists that are one stop of the Tab key each.  For
// quick hands: the second click of a double click presses no other button than the first.

const WAIT_MS = 150;  // after a change of the page, until it is looked at

const ICONS = {
  ".tabler-icon-list-search": word("All commands and keys"),
  ".mantine-Notification-closeButton svg": word("Close"),
};

// One stop each, with the keys that go on within.
const LISTS = [
  { list: "tbody", item: "tr[role=button]", back: "ArrowUp", on: "ArrowDown" },
  { list: ".wb-funnel", item: ".wb-filter", back: "ArrowLeft", on: "ArrowRight" },
  { list: "[role=tablist]", item: "[role=tab]", back: "ArrowUp", on: "ArrowDown" },
];

const UNFOLDED_MS = 300;  // after which an opened group has its height

const CORRECTED_MS = 4000;  // for which a field says that it did not take a number

const REFUSED_MS = 8000;  // for which a refusal stands beside what was refused

const FIELDS = "input:not([type=hidden]), textarea, [role=slider]";

const scene = document.getElementById("scene");

let left = null;     // where the focus was last in HTML that may be written anew
let timer = null;
let clicked = null;  // the button that was clicked last
let held = null;     // around the button that was clicked, until the pointer leaves it
let used = null;     // the field that was typed in last, or the button that was pressed since
let chosen = "";     // what says which row of a table is chosen

const here = () => scene.contentDocument;

const every = (selector, within = here()) => [...within.querySelectorAll(selector)];

function headings() {
  const marks = every("svg.tabler-icon-chevron-down, svg.tabler-icon-chevron-up");
  return marks.map((mark) => mark.parentElement).filter((one) => one.matches(".mantine-Paper-root"));
}

function dressHeading(heading) {
  const isOpen = heading.nextElementSibling?.getAttribute("aria-hidden") !== "true";
  heading.tabIndex = 0;
  heading.setAttribute("role", "button");
  heading.setAttribute("aria-expanded", isOpen);
}

function labelOf(field) {
  // What stands before it in the row that it is in, or in a row around that.
  let row = field.closest(".mantine-Flex-root");
  while (row) {
    const before = [...row.children].find((one) => !one.contains(field) && !one.querySelector(FIELDS));
    if (before?.textContent.trim()) return before.textContent.trim();
    row = row.parentElement.closest(".mantine-Flex-root");
  }
  return "";
}

function nameField(field) {
  const numbers = field.closest(".mantine-NumberInput-root")?.parentElement;
  const isOfThree = numbers && every(":scope > .mantine-NumberInput-root", numbers).length > 1;
  if (!isOfThree && (field.labels?.length || field.getAttribute("aria-label"))) return;
  const label = labelOf(field);
  if (!label) return;
  const root = field.closest(".mantine-NumberInput-root");
  const axis = isOfThree ? getComputedStyle(root, "::before").content.replaceAll('"', "") : "";
  field.setAttribute("aria-label", axis && axis !== "none" ? `${label} ${axis}` : label);
}

function nameIcons() {
  for (const [mark, name] of Object.entries(ICONS)) {
    for (const icon of every(mark)) {
      const button = icon.closest("button, [role=button], [tabindex]");
      if (button) button.setAttribute("aria-label", name);
    }
  }
}

function nameLandmarks() {
  // viser names neither what is the page nor what goes on.
  const root = here().getElementById("root");
  if (root && !root.hasAttribute("role")) root.setAttribute("role", "main");
  for (const bar of every("[role=progressbar]")) bar.setAttribute("aria-label", word("Progress"));
}

function dressList(list, item) {
  // Who comes by Tab finds what is chosen; within the list the arrows move the stop.
  const items = every(item, list);
  if (items.length < 2) return;
  const isChosen = (one) => one.getAttribute("aria-selected") === "true"
    || one.getAttribute("aria-pressed") === "true" || one.style.background.includes("--wb-chosen");
  const stop = items.find((one) => one === here().activeElement)
    ?? items.find((one) => one.dataset.stop) ?? items.find(isChosen) ?? items[0];
  for (const one of items) one.tabIndex = one === stop ? 0 : -1;
}

function dress() {
  timer = null;
  if (!here()?.body) return;
  headings().forEach(dressHeading);
  every(FIELDS).forEach(nameField);
  nameIcons();
  nameLandmarks();
  // What goes on changing is read out; what appears to be typed into gets the focus.
  for (const said of every(".wb-said")) said.parentElement.setAttribute("aria-live", "polite");
  for (const box of every("[data-focus]")) {
    delete box.dataset.focus;
    box.focus();
  }
  for (const dialog of every("[role=dialog]:not([data-met])")) {
    dialog.dataset.met = "";
    // A list would open over what is to be read.
    const field = dialog.querySelector("input:not([readonly], [type=checkbox], [aria-haspopup])");
    (field ?? dialog.querySelector(".wb-read"))?.focus();
  }
  for (const { list, item } of LISTS) every(list).forEach((one) => dressList(one, item));
  bringRefusals();
  showChosen();
  comeBack();
}

function showChosen() {
  // What is told of a row takes room from its table: the row stays in sight.
  const style = every(".wb-row-chosen").find((one) => one.parentElement.parentElement.offsetParent !== null);
  const rule = style?.textContent ?? "";
  if (rule === chosen) return;
  chosen = rule;
  if (rule) every(rule.split("{")[0]).forEach((row) => row.scrollIntoView({ block: "nearest" }));
}

function comeBack() {
  // Writing HTML anew takes the focus away: it belongs to the same place in what was written.
  if (!left || left.path[0].isConnected || here().activeElement !== here().body) return;
  const at = left.path.findIndex((one) => one.isConnected);
  if (at > 0) every(left.selector, left.path[at])[left.numbers[at]]?.focus({ preventScroll: true });
}

function came(event) {
  const { target } = event;
  const known = LISTS.find(({ item }) => target.matches(item));
  if (known?.list === "[role=tablist]" || !target.matches("[onclick][tabindex]")) {
    left = null;
    return;
  }
  const path = [];
  for (let one = target; one; one = one.parentElement) path.push(one);
  const selector = known?.item ?? "[onclick][tabindex]";
  left = { path, selector, numbers: path.map((one) => every(selector, one).indexOf(target)) };
  if (known) keepStop(target.closest(known.list), target, known.item);
}

function pointed(event) {
  // Who points elsewhere has left it.
  if (!left?.path[0].contains(event.target)) left = null;
}

function pressed(event) {
  // A button that has just come to stand under the pointer was not meant.
  if (!event.isTrusted) return;
  const button = event.target.closest("button, [role=button]");
  const isMeant = event.detail < 2 || button === clicked;
  clicked = button;
  if (isMeant && button?.matches(".mantine-Button-root")) used = button.parentElement;
  if (!isMeant) take(event);
}

function showOpened(event) {
  // What a heading opens may lie below what is in sight.
  const group = event.target.closest?.(".mantine-Paper-root[aria-expanded]")?.parentElement;
  if (group) setTimeout(() => group.scrollIntoView({ block: "nearest" }), UNFOLDED_MS);
}

function hold(event) {
  // What a press brings appears beside the button: the button's own text does not cover it.
  const button = event.isTrusted && event.target.closest(".mantine-Button-root");
  if (!button || event.detail === 0) return;
  letGo();
  held = button.parentElement;
  held.dataset.pressed = "";
}

function letGo(event) {
  if (!held || held.contains(event?.target)) return;
  delete held.dataset.pressed;
  held = null;
}

function tellWhole(event) {
  // A field of a list may be too narrow for what is chosen in it.
  const field = event.target;
  if (!field.matches(".mantine-Select-input")) return;
  if (field.scrollWidth > field.clientWidth) field.title = field.value;
  else field.removeAttribute("title");
}

function noteTyped(event) {
  const field = event.target.closest?.(".mantine-NumberInput-root");
  if (!field) return;
  used = field;
  event.target.dataset.typed = event.target.value;
}

function sayCorrected(event) {
  // Numbers out of bounds are put within them as the field is left: that is said, not done in silence.
  const field = event.target;
  const typedText = field.dataset?.typed;
  if (typedText === undefined) return;
  delete field.dataset.typed;
  setTimeout(() => {
    if (!typedText || !field.isConnected || Number(typedText) === Number(field.value)) return;
    const text = word("{typed} is not possible", { typed: typedText });
    noteBeside(field.closest(".mantine-NumberInput-root"), text, CORRECTED_MS);
  }, WAIT_MS);
}

function noteBeside(place, text, ms) {
  every(".wb-corrected", place).forEach((earlier) => earlier.remove());
  const note = here().createElement("div");
  note.className = "wb-corrected";
  note.setAttribute("role", "status");
  note.textContent = text;
  place.append(note);
  // What stands at the right end of the controls has its room to the left.
  const end = here().documentElement.clientWidth;
  if (note.getBoundingClientRect().right > end) note.classList.add("wb-leftwards");
  setTimeout(() => note.remove(), ms);
}

function bringRefusals() {
  // A refusal is read where a person typed or pressed, not at the far end of the scene.
  for (const toast of every(".mantine-Notification-root:not([data-brought])")) {
    toast.dataset.brought = "";
    const text = toast.querySelector(".mantine-Notification-description")?.textContent;
    const isRefusal = toast.querySelector(".mantine-Notification-title")?.textContent === word("Refused");
    if (!isRefusal || !text || !used?.isConnected || !used.getClientRects().length) continue;
    used.classList.add("wb-refusing");
    noteBeside(used, text, REFUSED_MS);
    toast.hidden = true;
  }
}

function keepStop(list, stop, item) {
  for (const one of every(item, list)) {
    one.tabIndex = one === stop ? 0 : -1;
    if (one === stop) one.dataset.stop = "here";
    else delete one.dataset.stop;
  }
}

function typed(event) {
  const { target, key } = event;
  if (event.ctrlKey || event.altKey || event.metaKey || !target.matches) return;
  if (target.hasAttribute("aria-expanded") && target.matches(".mantine-Paper-root")) {
    if (key !== "Enter" && key !== " ") return;
    take(event);
    target.click();
    return;
  }
  const known = LISTS.find(({ item }) => target.matches(item));
  if (!known) return;
  const items = every(known.item, target.closest(known.list));
  const at = items.indexOf(target);
  const to = { [known.back]: at - 1, [known.on]: at + 1, Home: 0, End: items.length - 1,
    PageUp: Math.max(0, at - 10), PageDown: Math.min(items.length - 1, at + 10) }[key];
  if (to === undefined) return;
  // Otherwise the arrows move the camera, too.
  take(event);
  const next = items[Math.min(Math.max(to, 0), items.length - 1)];
  keepStop(target.closest(known.list), next, known.item);
  next.focus();
  if (known.list === "[role=tablist]") openTab(next);
}

// What a person's Enter does: the tabs hear no click that a script makes.
function openTab(tab) {
  tab?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
}

function take(event) {
  event.preventDefault();
  event.stopPropagation();
}

function listen() {
  if (!here()) return;
  here().addEventListener("focusin", came);
  here().addEventListener("pointerdown", pointed, true);
  here().addEventListener("keydown", typed, true);
  here().addEventListener("click", pressed, true);
  here().addEventListener("click", hold, true);
  here().addEventListener("click", showOpened);
  here().addEventListener("pointerover", letGo, true);
  here().addEventListener("pointerover", tellWhole, true);
  here().addEventListener("focusin", tellWhole);
  here().addEventListener("input", noteTyped, true);
  here().addEventListener("focusout", sayCorrected, true);
  new MutationObserver(() => { timer ??= setTimeout(dress, WAIT_MS); }).observe(here(), {
    childList: true, subtree: true, attributes: true, attributeFilter: ["aria-hidden", "aria-selected", "aria-pressed"],
  });
  dress();
}

scene.addEventListener("load", listen);
if (here()?.readyState === "complete") listen();
