// The page that corrects what was found and chosen: what a click, a drag or a key does, and the panel.
import { bindFrame, frameKey, keyOf, order, proposal } from './both.js';
import * as clicks from './clicks.js';
import { begin, move, pixel, zoom } from './canvas.js';
import { bindFront, closed, front, typed } from './fronts.js';
import { as, bindPlacement, made, placement, renamed, standing } from './models.js';
import { blank, listOffers, taken } from './offers.js';
import { freeMask, page } from './refining.js';
import { ROOM, boxOf, chosen, draw } from './regions.js';
import { ask, changed, edit, find, nameOf, onChange, remember, solve, state, touch, undoable } from './state.js';

const get = (id) => document.getElementById(id);
const svg = get('view');
const SMALLEST = 4; // pixels of a side, below which a drag is a click
const HINTS = {
  select: 'Click what is wrong, in the picture or in a list. F draws a frame around what is missing.',
  box: 'Press at one corner of the thing, let go at the opposite one.',
  outline: 'Click around what is seen of it; Enter closes the outline.',
  join: 'Click what is a part of the chosen thing, one after the other; J or Esc: done.',
};
const things = () => state.project.objects.filter((item) => !ROOM.includes(item.label));
const seek = () => get('object').scrollIntoView({ block: 'start' });
const byMask = (mask) => state.project.objects.find((item) => item.mask === mask);

function choose(tool) {
  if (tool === 'join' && state.tool === 'join') tool = 'select';
  if (tool === 'click' && !clicks.offered()) { changed(); return; }
  clicks.end();
  state.draft = null; state.tool = tool; changed(); svg.focus({ preventScroll: true }); }

function heldAs(item) {
  if (!item.mounting) return '';
  return item.mounting.type === 2 ? '2' : `${item.mounting.type}/${item.mounting.walls.join('+')}`;
}

function button(item, text) {
  const result = document.createElement('button');
  result.type = 'button';
  result.textContent = text;
  result.setAttribute('aria-pressed', String(state.chosen === item.id));
  result.classList.toggle('changed', altered(item));
  if (altered(item)) result.title = 'changed: the next run makes it anew';
  result.addEventListener('click', () => { state.chosen = item.id; changed(); seek(); });
  return result;
}
const named = (item, text) => proposal(text, item.named && item.label === text, () => { clicks.end(); edit(() => Object.assign(item, { label: text, named: true })); });
// Whether a person has changed a thing since the page was opened: its doubts are about the last run.
const altered = (item) => state.before.get(item.mask) !== JSON.stringify(item);
function line(...parts) {
  const entry = document.createElement('li');
  entry.append(...parts);
  return entry;
}

// A name is doubted no more once a person has said it.
const doubtsOf = (item) => (made(item).doubts ?? []).filter(({ cause }) => cause !== 'name' || !(item.named || renamed(item)));
// What a click on a doubt leads to; what mends it at once has a button of its own.
const LEADS = { name: ['label', 'call it otherwise'], size: ['width', 'type its own length'], place: ['on', 'say what it stands on, or move it'], mounting: ['mounting', 'say how it is held'], affordance: ['models', 'choose another model'] };
function doubtLine(item, { text, leads, cures }) {
  const names = leads === 'name' ? state.proposals[item.mask] ?? [] : [];
  const about = button(item, names.length ? `${nameOf(item)}?` : `${nameOf(item)}${as(item)}: ${text}`);
  const [field, what] = LEADS[leads] ?? [];
  about.title = [names.length && text, what].filter(Boolean).join(': ');
  about.addEventListener('click', () => {
    const lead = get(field);
    if (lead?.select) { lead.focus(); lead.select(); } else lead?.scrollIntoView({ block: 'nearest' }); // keys would change a list
  });
  return line(about, ...names.map((name) => named(item, name)), ...mending(item, cures));
}
// Buttons that mend a doubt by what they say; `of`: the thing, wall or what was left out that one is about; `model`: the
// one in the last run that one rests on, gone where another will stand.
const isSaid = (item, set) => Object.keys(set).every((key) => JSON.stringify(item[key]) === JSON.stringify(set[key]));
const mending = (item, cures) => cures.flatMap(({ text, of, set, model }) => {
  if (model && model !== standing(item)) return [];
  const other = of && (byMask(of) ?? state.offers.find(({ mask }) => mask === of));
  return of && !other ? [] : proposal(other ? `${text} ${other.text ?? nameOf(other)}` : text, isSaid(item, set), () => edit((project) => {
    if (of && !byMask(of)) project.objects.push(taken(of));
    Object.assign(item, set);
    state.chosen = item.id;
  }));
});
function doubts() {
  const all = things().flatMap((item) => doubtsOf(item).map((doubt) => ({ item, doubt })));
  all.sort((one, other) => other.doubt.harm - one.doubt.harm);
  const lines = all.map(({ item, doubt }) => doubtLine(item, doubt));
  get('in-doubt').hidden = !lines.length;
  const [many, about] = [[lines.length, 'doubt'], [new Set(all.map(({ item }) => item)).size, 'thing']].map(([count, what]) => `${count} ${what}${count === 1 ? '' : 's'}`);
  get('in-doubt').querySelector('summary').textContent = `${many} about ${about}; a click leads to what mends it`;
  get('in-doubt').querySelector('ul').replaceChildren(...lines);
}

// What was said of things that are not found any more, until it is forgotten.
function listUnmatched() {
  const lines = state.project.unmatched.map(({ key, text }) => line(text, ' ', proposal('forget it', false, () => edit((project) => { project.unmatched = project.unmatched.filter((one) => one.key !== key); }))));
  get('unmatched').hidden = !lines.length;
  get('unmatched').querySelector('ul').replaceChildren(...lines);
}

function take(mask) {
  edit((project) => project.objects.push(taken(mask)));
  state.chosen = `drawn_${mask}`;
  choose('select');
  seek();
}

function panel() {
  get('hint').textContent = state.tool === 'click' ? clicks.hint() : HINTS[state.tool];
  get('trouble').textContent = state.trouble;
  get('trouble').hidden = !state.trouble;
  [get('undo').disabled, get('redo').disabled] = undoable().map((possible) => !possible);
  for (const tool of document.querySelectorAll('[data-tool]')) tool.setAttribute('aria-pressed', String(tool.dataset.tool === state.tool));
  listUnmatched();
  doubts();
  listOffers(take);
  get('objects').replaceChildren(...state.project.objects.map((item) => {
    const note = document.createElement('span');
    note.className = 'note';
    note.textContent = state.solved?.notes[item.id] ?? '';
    return line(button(item, nameOf(item)), note, ...(state.solved?.covered.includes(item.id) ? [proposal('to the front', false, () => order(item, 1))] : []));
  }));
  const item = chosen();
  get('object').hidden = !item;
  if (!item) return;
  for (const id of ['label', 'doors', 'drawers']) if (document.activeElement !== get(id)) get(id).value = item[id] ?? (id === 'label' ? '' : 0);
  get('proposals').replaceChildren(...(state.proposals[item.mask] ?? []).map((text) => named(item, text)));
  get('own-doubts').replaceChildren(...doubtsOf(item).map(({ text, cures }) => { const note = document.createElement('span'); note.className = 'note'; note.append(as(item) && `${as(item).trim()}: `, text); return line(note, ...mending(item, cures)); }));
  get('articulated').checked = item.articulated || item.doors + item.drawers > 0;
  get('thing').hidden = ROOM.includes(item.label);
  get('found').hidden = !state.known.includes(item.mask) || (!item.around && !item.outline.length);
  const walls = state.project.objects.filter((other) => other.label === 'wall');
  const ways = [['', 'geometry tells'], ['2', 'stands, touches no wall']];
  for (const one of walls) ways.push([`1/${one.mask}`, `hangs on ${nameOf(one)}`], [`3/${one.mask}`, `stands at ${nameOf(one)}`]);
  const held = heldAs(item);
  if (!ways.some(([value]) => value === held)) ways.push([held, 'as it was found']);
  get('mounting').replaceChildren(...ways.map(([value, text]) => new Option(text, value)));
  get('mounting').value = held;
  const others = things().filter((other) => other !== item && !above(other).includes(item));
  const now = made(item).support, found = now && (things().find((other) => made(other).id === now) ?? { label: now, id: now });
  get('on').replaceChildren(new Option(found ? `as found: ${found.mask ? nameOf(found) : found.label}` : 'as found', ''), new Option('the floor', 'floor'), ...others.map((other) => new Option(nameOf(other), other.mask)));
  get('on').value = item.on ?? '';
  get('on').disabled = item.mounting?.type === 1;
  front(item);
  placement(item, things().filter((other) => other !== item && !alike(other).includes(item)), nameOf);
}
// The things that carry a thing, from the next one down; likewise what it is like.
const chain = (item, key) => { const next = item && byMask(item[key]); return next ? [next, ...chain(next, key)] : []; };
const above = (item) => chain(item, 'on');
const alike = (item) => chain(item, 'like');

function add(region) {
  const mask = freeMask(), id = `drawn_${mask}`;
  edit((project) => project.objects.push({ ...blank(id, mask), ...region }));
  state.chosen = id;
  choose('select');
  get('label').focus();
}
function close() {
  const { points } = state.draft;
  if (points.length < 4) { choose('select'); return; } // the last one follows the pointer
  const outline = points.slice(0, -1);
  state.draft = null;
  if (!chosen()) add({ outline });
  else { edit(() => Object.assign(chosen(), { outline, pieces: [] })); choose('select'); }
}
function back() { // the last point again
  if (state.draft.points.length > 2) { state.draft.points.splice(-2, 1); draw(); } else choose('select');
}
function leaveOut(project, mask) {
  project.objects = project.objects.filter((item) => item.mask !== mask);
  for (const item of project.objects) for (const key of ['on', 'like']) if (item[key] === mask) item[key] = null;
}
function remove() {
  edit((project) => leaveOut(project, chosen().mask));
  state.chosen = null;
  changed();
}
function join(part) {
  edit((project) => {
    chosen().joins.push(part.mask, ...part.joins);
    leaveOut(project, part.mask);
  });
}
const round = (value) => Math.round(10 * value) / 10;
function setBox(item, corners) {
  item.around = corners.map((corner) => corner.map(round));
  Object.assign(item, { outline: [], pieces: [] });
}

let press = null;
svg.addEventListener('pointerdown', (event) => {
  svg.focus({ preventScroll: true });
  svg.setPointerCapture(event.pointerId);
  const at = pixel(event);
  press = { at, x: event.clientX, y: event.clientY, kind: 'pan' };
  if (event.button !== 0) return;
  if (['box', 'click'].includes(state.tool)) { press.kind = 'box'; state.draft = { kind: 'frame', points: [at, at] }; }
  else if (state.tool === 'outline') {
    press.kind = 'outline';
    if (state.draft) state.draft.points.push(at);
    else state.draft = { kind: 'outline', points: [at, at] };
  } else {
    const handle = event.target.dataset?.handle, id = event.target.closest('[data-object]')?.dataset.object;
    const offered = Number(event.target.closest('[data-offer]')?.dataset.offer);
    if (state.tool === 'join') {
      press.kind = 'join';
      if (chosen() && offered) join({ mask: offered, joins: [] });
      else if (chosen() && id && id !== state.chosen) join(find(id));
    } else if (offered) {
      press.kind = 'take';
      take(offered);
    } else if (handle) Object.assign(press, { kind: 'corner', handle, from: boxOf(chosen()) });
    else if (id) { Object.assign(press, { kind: state.chosen === id && !ROOM.includes(find(id).label) ? 'body' : 'choose', from: boxOf(find(id)) }); state.chosen = id; }
  }
  changed();
  if (press.kind === 'choose') seek();
});
svg.addEventListener('pointermove', (event) => {
  const at = pixel(event);
  if (!press) { if (state.draft?.kind === 'outline') { state.draft.points[state.draft.points.length - 1] = at; draw(); } return; }
  if (press.kind === 'pan') { move(press.at[0] - at[0], press.at[1] - at[1]); return; }
  if (press.kind === 'box') { state.draft.points[1] = at; draw(); return; }
  if (!['corner', 'body'].includes(press.kind) || !press.from) return;
  if (!press.moved && Math.hypot(event.clientX - press.x, event.clientY - press.y) < SMALLEST) return;
  if (!press.moved) { remember(); press.moved = true; }
  const [dx, dy] = [at[0] - press.at[0], at[1] - press.at[1]], [i, j] = press.handle ?? '';
  const moves = (k, l) => press.kind === 'body' || Number(l) === k;
  setBox(chosen(), press.from.map(([x, y], k) => [x + (moves(k, i) ? dx : 0), y + (moves(k, j) ? dy : 0)]));
  draw();
});
svg.addEventListener('pointerup', (event) => {
  const done = press;
  press = null;
  if (done?.moved) touch();
  if (done?.kind !== 'box') return;
  const [a, b] = state.draft.points;
  state.draft = null;
  const box = [[Math.min(a[0], b[0]), Math.min(a[1], b[1])], [Math.max(a[0], b[0]), Math.max(a[1], b[1])]];
  const small = box[1][0] - box[0][0] < SMALLEST || box[1][1] - box[0][1] < SMALLEST;
  if (state.tool === 'click') clicks.click(small ? null : a, small ? a : b, !event.shiftKey, page);
  else if (small) choose('select');
  else add({ around: box });
});
svg.addEventListener('wheel', (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY / 500), pixel(event)); }, { passive: false });
svg.addEventListener('mousedown', (event) => event.preventDefault()); // else it takes the focus from the label
svg.addEventListener('contextmenu', (event) => event.preventDefault());

// The picture, or the scene of rank 1 as the same camera sees it.
function swap() {
  const scene = get('made').getAttribute('aria-pressed') === 'false';
  get('made').setAttribute('aria-pressed', String(scene));
  svg.querySelector('image').setAttribute('href', scene ? 'made.png' : 'picture.jpg');
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
function next(by) {
  const { objects } = state.project;
  if (!objects.length) return;
  const at = objects.findIndex((item) => item.id === state.chosen);
  state.chosen = objects[(at + by + objects.length) % objects.length].id;
  changed();
  seek();
}
document.addEventListener('keydown', (event) => {
  if (frameKey(event)) return;
  const key = keyOf(event);
  const item = chosen(), box = item && boxOf(item);
  if (key === 'f') { state.chosen = null; choose('box'); }
  else if (key === 'c') choose('click');
  else if (key === 'o') choose('outline');
  else if (key === 'j' && item) choose('join');
  else if (key === 'Escape') { if (state.tool === 'select') state.chosen = null; choose('select'); }
  else if (key === 'Enter' && state.tool === 'click') { clicks.end(); changed(); }
  else if (key === 'g' && state.tool === 'click') clicks.another(page);
  else if (key === 'Enter' && state.draft?.kind === 'outline') close();
  else if (key === 'Backspace' && state.draft) back();
  else if ((key === 'Delete' || key === 'Backspace') && item) remove();
  else if (ARROWS[key] && box) {
    const [dx, dy] = ARROWS[key].map((value) => value * (event.shiftKey ? 10 : 1));
    edit(() => setBox(item, box.map(([x, y]) => [x + dx, y + dy])));
  } else if (key === 's' && !get('made').hidden) swap();
  else if (key === 'n' || key === 'p') next(key === 'n' ? 1 : -1);
  else return;
  event.preventDefault();
});

function bind() {
  for (const tool of document.querySelectorAll('[data-tool]')) tool.addEventListener('click', () => { if (tool.dataset.tool === 'box') state.chosen = null; choose(tool.dataset.tool); });
  bindFrame(() => { location.hash = 'made'; location.reload(); });
  get('made').addEventListener('click', swap);
  get('label').addEventListener('change', ({ target }) => { clicks.end(); edit(() => { chosen().label = target.value.trim() || null; }); });
  get('by-clicks').addEventListener('click', () => { choose('click'); clicks.go(chosen()); changed(); });
  for (const id of ['doors', 'drawers']) get(id).addEventListener('change', ({ target }) => edit(() => typed(chosen(), id, target.checkValidity() ? Number(target.value) : 0)));
  get('articulated').addEventListener('change', ({ target }) => edit(() => { if (target.checked) chosen().articulated = true; else closed(chosen()); }));
  get('mounting').addEventListener('change', ({ target }) => edit(() => {
    const [type, walls] = target.value.split('/');
    chosen().mounting = type ? { type: Number(type), walls: walls ? walls.split('+').map(Number) : [] } : null;
    if (type === '1') chosen().on = null;
  }));
  get('on').addEventListener('change', ({ target }) => edit(() => { chosen().on = ['', 'floor'].includes(target.value) ? target.value || null : Number(target.value); }));
  bindPlacement(chosen);
  bindFront(chosen, (item) => ({ ...state.project, mask: item.mask }));
  get('found').addEventListener('click', () => edit(() => Object.assign(chosen(), { around: null, outline: [], pieces: [] })));
  get('delete').addEventListener('click', remove);
}

async function start() {
  const answer = await ask('start');
  Object.assign(state, { project: answer.project, made: answer.made, proposals: answer.proposals, offers: answer.offers, free: answer.free, known: answer.known, chosen: answer.chosen });
  state.before = new Map(answer.project.objects.map((item) => [item.mask, JSON.stringify(item)]));
  get('made').hidden = !answer.pictured;
  get('command').textContent = answer.command;
  get('other').hidden = !answer.other;
  get('title').textContent = document.title = answer.project.picture;
  get('folder').textContent = answer.folder;
  get('categories').replaceChildren(...answer.categories.map((name) => new Option(name)));
  begin();
  bind();
  onChange(panel);
  onChange(draw);
  await solve();
  if (location.hash === '#made' && answer.pictured) swap();
  location.hash = '';
  clicks.offer(answer.clicks);
}
start().catch((error) => { get('trouble').textContent = error.message; get('trouble').hidden = false; });
