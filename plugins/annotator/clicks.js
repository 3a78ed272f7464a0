// The tool that outlines by clicks (C), on both pages: a click adds, with Shift it takes away, G takes another guess,
// Enter or a name ends the thing. What lies there, its names and its box are the server's.
import { ask, changed, copy, find, state } from './state.js';

const get = (id) => document.getElementById(id);
const kept = (item) => JSON.stringify([item.outline, item.pieces]);
export const outlined = (outlines) => ({ outline: outlines[0], pieces: outlines.slice(1) });

// The thing that is clicked now with its clicks, as long as its outline is as they made it.
export function clicked() {
  const now = state.clicked, item = now && find(now.id);
  return item && kept(item) === now.made ? { ...now, item } : null;
}
export const marks = () => (state.tool === 'click' ? clicked()?.clicks ?? [] : []);
export const end = () => { state.clicked = null; };
export const go = (item) => { state.clicked = { id: item.id, made: kept(item), clicks: [], guesses: [], at: 0 }; };

// One after the other; `page`: outlines of a thing that is there, and how it takes outlines and names.
let turn = Promise.resolve();
function inTurn(work) {
  turn = turn.then(work).catch((error) => { state.trouble = error.message; }).then(changed);
}
// A press that moves draws a box around the thing.
export function click(from, at, adds, page) {
  inTurn(async () => {
    const now = clicked(), clicks = from ? [] : [...now?.clicks ?? [], [...at, adds]];
    const { guesses } = await ask('outline', from ? { box: [from, at] } : { clicks, before: now ? page.outlines(now.item) : [] });
    state.trouble = guesses.length ? '' : 'Nothing is outlined there: click a thing.';
    if (guesses.length) await take({ clicks, guesses, at: 0 }, page);
  });
}
export function another(page) {
  inTurn(async () => {
    const now = clicked();
    if (now?.guesses.length > 1) await take({ clicks: now.clicks, guesses: now.guesses, at: (now.at + 1) % now.guesses.length }, page, true);
  });
}
async function take(said, page, renames = false) { // a further click changes what it shows, not what it is called
  const outlines = said.guesses[said.at];
  const now = clicked(), item = find(await page.put(outlines, await ask('names', { outlines, ...page.about(now?.item) }), now, renames));
  state.chosen = item.id;
  state.clicked = { ...said, id: item.id, made: kept(item), was: copy(item) };
}

export function hint() {
  const now = clicked();
  if (!now) return 'Click a thing, or draw a box around it from corner to corner: its outline is found.';
  return `Click what more belongs to it, Shift+click what does not${now.guesses.length > 1 ? ', G for another outline' : ''}; Enter: the next thing, Esc: done.`;
}

let refusal = 'The picture is being looked at: press C again once that is done.';
// The tool is there where weights are, and works once the picture is looked at.
export async function offer(there) {
  get('label').addEventListener('blur', end); // after its change: who leaves the name has named the thing
  for (const id of ['clicking', 'by-clicks']) get(id).hidden = !there;
  get('clicking').disabled = get('by-clicks').disabled = true;
  if (!there) { refusal = 'Clicks outline things once the networks\' weights are there: make weights. B draws a box.'; return; }
  get('clicking').textContent = 'Click: looking…';
  try {
    await ask('ready');
    get('clicking').disabled = get('by-clicks').disabled = false;
    get('clicking').textContent = 'Click (C)';
    if (state.trouble === refusal) state.trouble = '';
    refusal = '';
  } catch (error) { refusal = get('clicking').textContent = `Click: ${error.message}`; }
  changed();
}
// Whether the tool can be taken; else the page says why not.
export function offered() {
  if (refusal) state.trouble = refusal;
  return !refusal;
}
