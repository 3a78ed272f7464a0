// Gestures and keys: what a click, a movement or a key does to the drawing.
import { frameKey, keyOf } from './both.js';
import { ask, changed, copy, edit, find, freeId, isWall, nameOf, object, remember, remove, solve, state, touch, wall } from './state.js';
import * as clicks from './clicks.js';
import { page, take } from './outlining.js';
import { move, pixel, zoom } from './canvas.js';
import { draw } from './drawing.js';

const svg = document.getElementById('view');
const STEPS = { x: 'camera', y: 'camera', z: 'camera', measure: 'camera', wall: 'walls', box: 'objects', round: 'objects', outline: 'objects', click: 'objects' };
const FAR = 8; // screen pixels: a press that moves farther is a drag, whose end counts as a second click
const STANDING = ['Click the lower left corner of its front.', 'Click the lower right corner of its front (Shift: not along the walls).',
  'Click its upper edge in front.', 'Click any rear corner that you see (Enter: guess its depth).'];
const HANGING = ['', 'Click the opposite corner of its front.', 'Click a rear corner, where it meets the wall (Enter: flat).'];
const ROUND = ['Click the left end of its base.', 'Click the right end of its base.', 'Click its top: in the middle, or its left or right end if it is wider there than its foot.'];
const HINTS = {
  line: ['Click one end of an edge that runs this way, as long as you can find.', 'Click its other end.'],
  wall: ['Click where this wall meets the floor.', 'Click a second place of the same edge (Shift: not along the room).'],
  measure: ['Click where the known length begins, on the floor.', 'Click where it ends.'],
  outline: ['Click around what is seen of it; Enter closes the outline.'],
};
const IDLE = {
  camera: 'Move the ends of lines until the grid lies flat on the floor, then tell one length.',
  walls: 'W draws a wall by its lower edge.', objects: 'B draws an object, R a round one. Click one to change it.', write: 'Write the folder; everything is saved as you go.',
};

// What it stands or hangs on, before the first click as well.
function onto() {
  const on = state.draft?.on ?? state.under;
  if (!on) return '';
  const item = find(on);
  if (isWall(on)) return `It hangs on ${on.replace('_', ' ')}. `;
  if (!item) return 'It stands on the floor. ';
  const first = (state.draft?.points.length ?? 1) < 2;
  return `It stands on ${nameOf(item)}. ${first ? 'Its yellow top must be the surface that is touched, as of the worktop. ' : ''}`;
}

export function hint() {
  if (state.tool === 'select') return IDLE[state.step];
  if (state.tool === 'click') return clicks.hint();
  const drawn = (state.draft?.points.length ?? 1) - 1;
  if (state.tool === 'round') return onto() + (ROUND[drawn] ?? '');
  const worktop = drawn === 2 && state.draft?.on === 'floor' ? ' Of a counter: that of the worktop, not of the doors.' : '';
  if (state.tool === 'box') return onto() + ((state.draft && isWall(state.draft.on) ? HANGING : STANDING)[drawn] ?? '') + worktop;
  const known = HINTS[state.tool] ?? HINTS.line;
  return known[Math.min(drawn, known.length - 1)];
}

export function choose(tool) {
  state.draft = state.under = null;
  clicks.end();
  if (tool === 'click' && !clicks.offered()) { state.step = STEPS.click; changed(); return; }
  if (tool === 'outline' && (!state.chosen || isWall(state.chosen))) tool = 'select';
  state.tool = tool;
  if (STEPS[tool]) state.step = STEPS[tool];
  changed();
  solve();
  svg.focus({ preventScroll: true });
}

export function step(name) { state.step = name; state.handle = null; choose('select'); }
function needed() {
  if (state.draft.kind === 'box') return state.draft.round || isWall(state.draft.on) ? 3 : 4;
  return state.tool === 'outline' ? Infinity : 2;
}

// The last point of a draft follows the pointer until it is clicked.
async function click(at, shift) {
  const free = state.draft?.free || (shift && state.draft?.points.length === 2);
  if (!state.draft) {
    const kind = { x: 'line', y: 'line', z: 'line', round: 'box' }[state.tool] ?? state.tool;
    const draft = { kind, points: [at, at], free: false, round: state.tool === 'round', on: state.next };
    state.draft = draft;
    if (kind === 'box' && draft.on === 'auto') {
      draft.on = 'floor';
      try { draft.on = (await ask('support', { project: state.project, pixel: at, stands: draft.round })).on; } catch (error) { state.trouble = error.message; }
      if (state.draft !== draft) return;
      if (draft.round && isWall(draft.on)) draft.round = false;
    }
  } else {
    state.draft.free = Boolean(free);
    state.draft.points[state.draft.points.length - 1] = at;
    if (state.draft.points.length >= needed()) { finish(state.draft.points.length); return; }
    state.draft.points.push(at);
  }
  changed();
  solve();
}

// Asks what is under the pointer, before anything is clicked; one question at a time, the last one counts.
let looking = false, later = null;
async function look(at) {
  if (looking) { later = at; return; }
  looking = true;
  const on = state.next;
  try {
    const under = on === 'auto' ? (await ask('support', { project: state.project, pixel: at, stands: state.tool === 'round' })).on : on;
    if (state.under !== under && !state.draft && ['box', 'round'].includes(state.tool)) { state.under = under; changed(); }
  } catch { /* reported when it is clicked */ } finally { looking = false; }
  if (later) { const next = later; later = null; look(next); }
}

// One after the other: the first click of a box waits for the server to say what is there.
let drawing = Promise.resolve();
const clicked = (at, shift) => { drawing = drawing.then(() => click(at, shift)); };

// Keep the first `count` points of the draft as what the tool draws.
function finish(count) {
  const { tool, draft } = state;
  const least = tool === 'outline' || (draft.kind === 'box' && !isWall(draft.on)) ? 3 : 2;
  if (count < least) return; // more is to come, or Esc
  draft.points.length = count;
  state.draft = null;
  edit((project) => {
    if (draft.kind === 'box') {
      const id = freeId('object');
      project.objects.push({ ...object(id, draft), label: '', articulated: false, doors: 0, drawers: 0, outline: [] });
      state.chosen = id;
      state.next = 'auto';
    } else if (tool === 'wall') project.walls.push(wall(freeId('wall'), draft));
    else if (tool === 'measure') project.scale = { ...project.scale, kind: project.scale.kind === 'floor' ? 'floor' : 'upright', points: draft.points };
    else if (tool === 'outline') Object.assign(find(state.chosen), { outline: draft.points, pieces: [] });
    else project.perspective.guides.push({ axis: tool, a: draft.points[0], b: draft.points[1] });
  });
  state.tool = 'select';
  changed();
  if (draft.kind === 'box') document.getElementById('label').focus();
  if (tool === 'measure') { const field = document.getElementById('scale-metres'); field.focus(); field.select(); }
}

export function cancel() {
  if (state.tool === 'select') state.chosen = state.handle = null;
  state.draft = null; state.tool = 'select'; changed(); solve();
}

// The place in the drawing that a handle moves.
function place(name) {
  const [kind, which, point] = name.split('/');
  const { perspective, scale } = state.project;
  if (kind === 'horizon') { perspective.horizon ??= copy(state.solved.horizon); return [perspective.horizon, point]; }
  if (kind === 'vanishing') { perspective[which] ??= copy(state.solved.vanishing[which]); return [perspective, which]; }
  if (kind === 'guide') return [perspective.guides[which], point];
  if (kind === 'measure') return [scale.points, point];
  if (kind === 'wall') return [find(which), point];
  return [find(which)[kind === 'outline' ? 'outline' : 'points'], point];
}

function shift(name, to) {
  const [holder, key] = place(name);
  holder[key] = to(holder[key]).map((value) => Math.round(10 * value) / 10);
  touch();
}

let press = null;
svg.addEventListener('pointerdown', (event) => {
  svg.focus({ preventScroll: true });
  const at = pixel(event), name = event.target.dataset?.handle;
  svg.setPointerCapture(event.pointerId);
  press = { x: event.clientX, y: event.clientY, at, moved: false, handle: null, pan: event.button === 1 };
  if (event.button !== 0) return;
  if (state.tool === 'click') { state.draft = { kind: 'frame', points: [at, at] }; return; }
  if (state.tool !== 'select') { clicked(at, event.shiftKey); return; }
  const item = event.target.closest('[data-object]')?.dataset.object, offered = event.target.closest('[data-offer]')?.dataset.offer;
  state.handle = name ?? null;
  if (offered) take(offered);
  else if (name) press.handle = name;
  else if (item && item !== 'draft') { state.chosen = item; state.step = 'objects'; }
  else press.pan = true;
  changed();
});
svg.addEventListener('pointermove', (event) => {
  const at = pixel(event);
  if (press) press.moved ||= Math.hypot(event.clientX - press.x, event.clientY - press.y) > FAR;
  if (press?.pan) { move(press.at[0] - at[0], press.at[1] - at[1]); return; }
  if (press?.handle) {
    if (!press.kept) { remember(); press.kept = true; }
    shift(press.handle, () => at);
  } else if (state.draft) {
    state.draft.points[state.draft.points.length - 1] = at;
    draw();
    solve();
  } else if (['box', 'round'].includes(state.tool)) look(at);
});
svg.addEventListener('pointerup', (event) => {
  if (press && state.draft?.kind === 'frame') {
    state.draft = null;
    clicks.click(press.moved ? press.at : null, press.moved ? pixel(event) : press.at, !event.shiftKey, page);
  } else if (press?.moved && state.draft && !press.pan) clicked(pixel(event), event.shiftKey);
  press = null;
});
svg.addEventListener('wheel', (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY / 500), pixel(event)); }, { passive: false });
svg.addEventListener('mousedown', (event) => event.preventDefault()); // else it takes the focus from the label
svg.addEventListener('contextmenu', (event) => event.preventDefault());

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const TOOLS = { x: 'x', y: 'y', z: 'z', m: 'measure', w: 'wall', b: 'box', r: 'round', o: 'outline', c: 'click' };
const NUMBERS = { 1: 'camera', 2: 'walls', 3: 'objects', 4: 'write' };

function next(by) {
  const { objects } = state.project;
  if (!objects.length) return;
  const at = objects.findIndex((item) => item.id === state.chosen);
  state.chosen = objects[(at + by + objects.length) % objects.length].id;
  state.step = 'objects';
  changed();
}

function erase() {
  const [kind, which] = state.handle?.split('/') ?? [];
  if (kind === 'guide') { state.handle = null; edit((project) => project.perspective.guides.splice(Number(which), 1)); }
  else if (kind === 'wall') remove(which);
  else if (state.chosen) remove(state.chosen);
}

document.addEventListener('keydown', (event) => {
  if (frameKey(event)) return;
  const key = keyOf(event);
  if (TOOLS[key]) choose(TOOLS[key]);
  else if (NUMBERS[key]) step(NUMBERS[key]);
  else if (key === 'Escape') cancel();
  else if (key === 'Enter' && state.draft) drawing = drawing.then(() => state.draft && finish(state.draft.points.length - 1));
  else if (key === 'Enter' && state.tool === 'click') { clicks.end(); changed(); }
  else if (key === 'g' && state.tool === 'click') clicks.another(page);
  else if (key === 'Backspace' && state.draft) { if (state.draft.points.length > 2) { state.draft.points.splice(-2, 1); changed(); solve(); } else cancel(); }
  else if (key === 'Delete' || key === 'Backspace') erase();
  else if (ARROWS[key] && state.handle) {
    const [dx, dy] = ARROWS[key].map((value) => value * (event.shiftKey ? 10 : 1));
    remember();
    shift(state.handle, ([u, v]) => [u + dx, v + dy]);
  } else if (key === 'n' || key === 'p') next(key === 'n' ? 1 : -1);
  else return;
  event.preventDefault();
});
