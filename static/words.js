// What the scripts of our pages say, in the language that the server has put beside the page; and the
// choice of another one, which the server keeps and comes back with.
"use strict";

const WORDS = JSON.parse(document.body.dataset.words);
const LANGUAGE = document.querySelector("#language select");

// An English text in the language of the page; what stands in braces is a place, filled in.
function word(text, values = {}) {
  return (WORDS[text] ?? text).replace(/\{(\w+)\}/g, (place, name) => values[name] ?? place);
}

LANGUAGE.value = document.documentElement.lang;
LANGUAGE.addEventListener("change", () => LANGUAGE.form.submit());
