// What was drawn, what the server made of it, undo and redo. Geometry is the server's; nothing is computed here.

export const state = {
  project: null, fresh: null, solved: null, depth: false,
  step: 'camera', tool: 'select', draft: null, chosen: null, handle: null, grid: true, trouble: '', under: null, next: 'auto', proposals: {}, clicked: null,
};
const listeners = [];
const past = [];
const future = [];
let again = false, saving = 0, savedAt = 0;
let edits = 0, kept = 0, failed = false; // changes so far, those that are saved, and whether saving them failed

export const onChange = (listener) => listeners.push(listener);
export const changed = () => listeners.forEach((listener) => listener());
export const copy = (value) => JSON.parse(JSON.stringify(value));

const LARGEST = 60000; // bytes: somewhat less than a browser still sends once a page is closed
const isLarge = (text) => new Blob([text]).size > LARGEST;
let page = 0; // which of all tabs this is: only the newest may write
export async function ask(name, body, leaving = false) {
  const headers = { 'Content-Type': 'application/json', 'X-Page': page, 'X-Edits': edits }, text = JSON.stringify(body);
  const what = text === undefined ? {} : { method: 'POST', headers, body: text, keepalive: leaving && !isLarge(text) };
  const reply = await fetch(name, what).catch(() => { throw new Error('the command that shows this page does not answer: was it ended?'); });
  const answer = await reply.json();
  if (!reply.ok) throw new Error(answer.error);
  page = answer.page ?? page;
  return answer;
}

function drawn() {
  const project = copy(state.project);
  if (state.draft?.kind === 'box' && state.draft.points.length > 1) project.objects.push(object('draft', state.draft));
  if (state.draft?.kind === 'wall' && state.draft.points.length > 1) project.walls.push(wall('draft', state.draft));
  return project;
}

let solving = null;
export function solve() { // done when what was solved is what is drawn
  again = true;
  solving ??= solveAll();
  return solving;
}
async function solveAll() {
  try {
    while (again) {
      again = false;
      try {
        state.solved = await ask('solve', drawn());
        state.trouble = state.solved.notes.scale ?? '';
      } catch (error) {
        state.trouble = error.message;
      }
      changed();
    }
  } finally {
    solving = null;
  }
}

export const remember = () => { past.push(JSON.stringify(state.project)); future.length = 0; if (past.length > 300) past.shift(); };

// Change the drawing; `step` false: part of a movement that was remembered when it began.
export function edit(change, step = true) {
  if (step) remember();
  change(state.project);
  touch();
}

// What a person has changed is unsure no more.
function settle() {
  if (!past.length || !state.project.objects.some((item) => item.unsure)) return;
  const before = new Map(JSON.parse(past.at(-1)).objects.map((item) => [item.id, JSON.stringify(item)]));
  for (const item of state.project.objects) if (before.has(item.id) && before.get(item.id) !== JSON.stringify(item)) item.unsure = false;
}

export function touch() {
  settle();
  edits += 1;
  if (!failed) tell('…');
  saving ||= setTimeout(save, Math.max(0, savedAt + 250 - Date.now())); // at once, but not with every step of a movement
  changed();
  solve();
}

let sending = Promise.resolve();
export function save() { // one after the other: what is saved last is the newest
  clearTimeout(saving);
  saving = 0;
  savedAt = Date.now();
  sending = sending.then(send);
  return sending;
}
async function send(leaving) {
  const sent = edits;
  try {
    await ask('save', state.project, leaving);
    kept = Math.max(kept, sent);
    failed = false;
    tell(kept === edits ? 'saved' : '…');
  } catch (error) {
    failed = kept < edits;
    if (failed) tell(`NOT saved: ${error.message}`);
  }
}

function tell(text) {
  const saved = document.getElementById('saved');
  saved.textContent = text;
  saved.classList.toggle('failed', failed);
}

// What is not saved yet is sent, also if the page is closed.
export function hurry() { if (kept < edits) send(true); }
// Whether leaving loses something, as it is too large to be sent then, or cannot be saved.
export const unsaved = () => kept < edits;
export const loses = () => unsaved() && (failed || isLarge(JSON.stringify(state.project)));

function travel(from, to) {
  if (!from.length) return;
  to.push(JSON.stringify(state.project));
  state.project = JSON.parse(from.pop());
  state.draft = state.handle = null;
  state.tool = 'select';
  if (state.chosen && !find(state.chosen)) state.chosen = null;
  touch();
}
export const undo = () => travel(past, future);
export const redo = () => travel(future, past);
export const undoable = () => [past.length > 0, future.length > 0];

export const find = (id) => state.project.objects.find((item) => item.id === id) ?? state.project.walls?.find((item) => item.id === id);
const numbered = new Map(); // label -> ids in the order in which they got it
// Numbered where there are, or were, more of a kind: a number stays when others get a name or are deleted.
export function nameOf(item) {
  if (!item.label || item.label === 'object') return item.id.replace('_', ' ');
  const alike = state.project.objects.filter((other) => other.label === item.label).map((other) => other.id);
  const ids = [...new Set([...(numbered.get(item.label) ?? []), ...alike])];
  numbered.set(item.label, ids);
  return ids.length > 1 ? `${item.label} ${ids.indexOf(item.id) + 1}` : item.label;
}
export const object = (id, draft) => ({ id, on: draft.on, points: copy(draft.points), free: draft.free, round: draft.round });
export const wall = (id, draft) => ({ id, a: draft.points[0], b: draft.points[1], free: draft.free });
export const isWall = (id) => state.project.walls.some((item) => item.id === id);

export function freeId(kind) {
  for (let n = 1; ; n += 1) if (!find(`${kind}_${n}`)) return `${kind}_${n}`;
}

// A box on a wall is marked by two opposite corners of its front, one that stands by its foot and its top: what changes
// from one to the other keeps the corners that it has in the picture.
export function carried(item, on) {
  const hung = isWall(item.on), hangs = isWall(on), [a, b, c, d] = item.points;
  const seen = item.round ? [] : state.solved.boxes[item.id]?.corners ?? [];
  item.on = on;
  item.round &&= !hangs;
  if (hung === hangs) return;
  if (hung && c && Math.abs(a[1] - b[1]) < Math.min(a[1], b[1]) - c[1]) return; // it was marked as what stands: foot, foot, top
  if (hangs && seen[0] && seen[5]) item.points = [seen[0], seen[5], ...(d ? [d] : [])];
  else if (hangs) item.points = [a, [b[0], (c ?? b)[1]], ...(d ? [d] : [])];
  else if (seen[0] && seen[1] && seen[5]) item.points = [seen[0], seen[1], seen[5], ...(c ? [c] : [])];
  else item.points = [[a[0], Math.max(a[1], b[1])], [b[0], Math.max(a[1], b[1])], [b[0], Math.min(a[1], b[1])], ...(c ? [c] : [])];
}

// What stood on it stands on what carried that.
export function remove(id) {
  edit((project) => {
    const on = isWall(id) ? 'floor' : find(id).on;
    for (const item of project.objects) if (item.on === id) carried(item, isWall(on) ? 'floor' : on);
    project.objects = project.objects.filter((item) => item.id !== id);
    project.walls = project.walls.filter((item) => item.id !== id);
    if (project.scale.object === id) project.scale = { ...project.scale, kind: 'camera', metres: state.solved.camera.above, object: null };
  });
  state.chosen = state.handle = null;
  changed();
}
