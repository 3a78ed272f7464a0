// What both pages have: buttons above the picture, writing and closing, and keys that are the same on both.
import { fit, zoom } from './canvas.js';
import { bindMaking } from './making.js';
import { ask, changed, edit, find, hurry, loses, onChange, redo, save, solve, state, undo, unsaved } from './state.js';

const get = (id) => document.getElementById(id);
function whole() { fit(); changed(); }

let writing = Promise.resolve();
function write() { // one after the other: what is written last is the newest
  writing = writing.then(writeOnce);
  return writing;
}
async function writeOnce() { // whether it was written
  let written = false;
  await save();
  await solve(); // its doubts are of what is written, and no answer comes after this one's
  try {
    if (state.solved.camera?.factor) throw new Error('Say first how high the camera is: a button answers the question here.');
    const answer = await ask('write', state.project);
    get('ids').textContent = Object.values(answer.ids).join(', ');
    get('command').textContent = answer.command;
    get('doubts').replaceChildren(...answer.notes.map((text) => { const entry = document.createElement('li'); entry.className = 'note'; entry.textContent = text; return entry; }));
    get('preview').src = `preview.jpg?${Date.now()}`;
    get('written').hidden = false;
    get('written').scrollIntoView({ block: 'start' });
    state.trouble = '';
    written = true;
  } catch (error) {
    state.trouble = error.message;
  }
  changed();
  return written;
}

// In the picture before all others, or behind them, whatever is nearer.
export function order(item, by) {
  const layers = state.project.objects.map((other) => other.layer ?? 0);
  edit(() => { item.layer = by > 0 ? Math.max(0, ...layers) + 1 : Math.min(0, ...layers) - 1; });
}

// `made`: what follows a run that ended well.
export function bindFrame(made) {
  get('undo').addEventListener('click', undo);
  get('redo').addEventListener('click', redo);
  get('closer').addEventListener('click', () => zoom(0.8));
  get('farther').addEventListener('click', () => zoom(1.25));
  get('fit').addEventListener('click', whole);
  for (const button of document.querySelectorAll('[data-key]')) { // where there is no keyboard
    button.addEventListener('click', () => get('view').dispatchEvent(new KeyboardEvent('keydown', { key: button.dataset.key, bubbles: true })));
  }
  onChange(() => { get('drafting').hidden = !state.draft || state.draft.kind === 'frame'; });
  for (const one of document.querySelectorAll('[data-layer]')) one.addEventListener('click', () => order(find(state.chosen), Number(one.dataset.layer)));
  get('object').addEventListener('submit', (event) => event.preventDefault());
  get('write').addEventListener('click', write);
  bindMaking(write, made);
  get('close').addEventListener('click', async () => {
    if (!await write()) return;
    try {
      await ask('close', {});
      get('hint').textContent = 'Done: this page can be closed.';
    } catch (error) {
      state.trouble = error.message;
      changed();
    }
  });
  get('other').addEventListener('click', async () => {
    if (unsaved()) await save();
    if (!unsaved()) ask('turn', {}).then(() => location.reload(), (error) => { state.trouble = error.message; changed(); });
  });
  addEventListener('beforeunload', (event) => {
    if (document.activeElement.matches('input')) document.activeElement.blur(); // what is typed there is an edit
    hurry();
    if (loses()) event.preventDefault(); // the browser asks
  });
  addEventListener('pagehide', hurry);
  document.addEventListener('visibilitychange', () => { if (document.hidden) hurry(); });
}

// A name that is proposed, as a button.
export function proposal(text, taken, take) {
  const button = document.createElement('button');
  button.type = 'button';
  button.textContent = text;
  button.setAttribute('aria-pressed', String(taken));
  button.addEventListener('click', take);
  return button;
}

export const keyOf = (event) => (event.key.length === 1 ? event.key.toLowerCase() : event.key);

// Whether a key was one of these, or is none of the page's: typed into a field, or pressed on a button.
export function frameKey(event) {
  const key = keyOf(event), typing = event.target.matches('input, select');
  if (event.ctrlKey || event.metaKey) {
    if (key === 's') { event.preventDefault(); document.querySelector('[data-step="write"]')?.click(); get('write').click(); }
    else if (!typing && key === 'z') { event.preventDefault(); (event.shiftKey ? redo : undo)(); }
    else if (!typing && key === 'y') { event.preventDefault(); redo(); }
    return true;
  }
  if (typing) {
    if (key === 'Enter' || key === 'Escape') { event.preventDefault(); event.target.blur(); get('view').focus({ preventScroll: true }); }
    return true;
  }
  if (event.target.matches('button, summary') && (key === 'Enter' || key === ' ')) return true;
  if (key === '+' || key === '=') zoom(0.8);
  else if (key === '-') zoom(1.25);
  else if (key === '0') whole();
  else return false;
  event.preventDefault();
  return true;
}
