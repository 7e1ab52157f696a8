// Fetches the program of the page while a password is typed: on a slow line that is most of what a
// first visit waits for. Two at a time leave connections for the login itself, and what has
// come to its end is kept by the browser when the page goes on.
const waiting = document.currentScript.dataset.pieces.split(" ").filter(Boolean);

async function fetchAll() {
  let pause = 1000;
  for (let piece; (piece = waiting.shift()); ) {
    try {
      await (await fetch(piece, { priority: "low" })).arrayBuffer();
    } catch {
      // Cut off, or nobody there: asked for again behind the others.  What is still missing then
      // the page behind the login fetches, and says what is wrong.
      waiting.push(piece);
      await new Promise((done) => setTimeout(done, pause));
      pause *= 2;
    }
  }
}

fetchAll();
fetchAll();
