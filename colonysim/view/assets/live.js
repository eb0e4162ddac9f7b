// A run under way: the page asks the server that it came from for what is new.

import { begin, extend } from "./growth.js";
import { start } from "./main.js";
import { Teacher } from "./teacher.js";
import { decode, unpack } from "./unpack.js";

const NO_NEWS = 250; // milliseconds from an answer without news to the next question
const NO_ANSWER = 2000; // and from one that never came
const NUMBER = 4; // bytes of a number

const sleep = (milliseconds) => new Promise((wake) => { setTimeout(wake, milliseconds); });

/** The blocks from a number on, and the number of the one after them. */
async function blocksFrom(number, panel) {
  const token = new URLSearchParams(location.search).get("token");
  const of = panel ? `&run=${panel}` : "";
  const answer = await fetch(`rows?from=${number}${of}&token=${encodeURIComponent(token)}`, { cache: "no-store" });
  if (answer.status === 410) location.reload(); // another run has begun in its place
  if (!answer.ok) throw new Error(answer.statusText);
  const raw = await answer.arrayBuffer();
  const numbers = new DataView(raw);
  const blocks = [];
  for (let at = NUMBER; at < raw.byteLength;) {
    const length = numbers.getUint32(at, true);
    blocks.push(new Uint8Array(raw, at + NUMBER, length));
    at += NUMBER + length;
  }
  return { blocks, next: numbers.getUint32(0, true) + blocks.length };
}

async function followRun(run) {
  let page = null, next = 0;
  const tell = (text, over = false) => { (page ?? { tell: tellEarly }).tell(text, over); };
  begin(run);
  tell("waits for the run to begin");
  while (run.status === "running" && !run.trouble) {
    let news;
    try {
      news = await blocksFrom(next, run.panel);
    } catch {
      tell("no connection: colonysim has ended, or the run with it");
      await sleep(NO_ANSWER);
      continue;
    }
    for (const block of news.blocks) extend(run, await decode(block));
    ({ next } = news);
    if (news.blocks.length && page) page.grown();
    else if (run.episodes.length && !page) {
      page = start(run);
      if (run.panel) page.teacher = new Teacher(run, page);
    }
    if (page) tell("under way");
    if (!news.blocks.length) await sleep(NO_NEWS);
  }
  tell(run.trouble ? `the run goes on, but it cannot be shown any further: ${run.trouble}` : `the run is over: ${run.status}`, true);
}

function tellEarly(text) {
  const state = document.getElementById("state");
  state.hidden = false;
  state.textContent = text;
}

const data = document.getElementById("data");
unpack(data.textContent).then((run) => {
  data.remove();
  return followRun(run);
}).catch((error) => {
  tellEarly(`this page cannot go on: ${error.message}`);
  throw error;
});
