// The frame around the scene: goes to the login when the login has ended, comes back when the
// server does, and is light or dark as the scene is.
"use strict";

const RETRY_MS = 1000;
const OVER = 4401;  // close code: the login has ended

const line = document.getElementById("link");
const scene = document.getElementById("scene");

function leave() {
  // Without what is on screen: whoever comes next may be somebody else.
  scene.remove();
  location.replace("/login");
}

async function again() {
  try {
    const answer = await fetch("/who", { cache: "no-store" });
    if (answer.status === 401) {
      leave();
      return;
    }
    if (answer.ok) {
      const who = await answer.json();
      if (who.name !== document.getElementById("name").textContent) {
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
  const presence = new WebSocket(`${scheme}//${location.host}/presence`);
  presence.onopen = () => { line.textContent = ""; };
  presence.onclose = (event) => {
    if (event.code === OVER) {
      leave();
      return;
    }
    line.textContent = "No connection. Trying again.";
    setTimeout(again, RETRY_MS);
  };
}

function follow() {
  const root = scene.contentDocument?.documentElement;
  if (!root) return;
  const take = () => {
    const scheme = root.getAttribute("data-mantine-color-scheme");
    if (scheme) document.documentElement.dataset.scheme = scheme;
  };
  new MutationObserver(take).observe(root, { attributes: true });
  take();
  scene.contentWindow.focus();
}

// Until the scene says how it looks, as the system wants it.
if (matchMedia("(prefers-color-scheme: dark)").matches) {
  document.documentElement.dataset.scheme = "dark";
}
scene.addEventListener("load", follow);
if (scene.contentDocument?.readyState === "complete") follow();
stay();
