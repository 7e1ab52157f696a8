// Fetches the program of the page while a password is typed: on a slow line that is most of what a
// first visit waits for. Two at a time leave connections for the login itself, and what has
// come to its end is kept by the browser when the page goes on.
const waiting = document.currentScript.dataset.pieces.split(" ").filter(Boolean);

async function fetchAll() {
  for (let piece; (piece = waiting.shift()); ) {
    try {
      await (await fetch(piece, { priority: "low" })).arrayBuffer();
    } catch {
      return; // The page behind the login fetches what is missing, and says what is wrong.
    }
  }
}

fetchAll();
fetchAll();
