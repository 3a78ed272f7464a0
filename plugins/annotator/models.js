// The part of the correcting page that is about a thing as it was placed: size, front, place, and which model it has.
import { ask, changed, edit, state } from './state.js';

const get = (id) => document.getElementById(id);
const STEP = 0.02; // metres
const shown = new Map(); // models of a thing, by mask value, once they were asked for
export const made = (item) => state.made[item.mask] ?? {};
// What a thing was called when its doubts were found: in the last run, else as the page was opened.
export const calledThen = (item) => made(item).label ?? JSON.parse(state.before.get(item.mask) ?? '{}').label ?? 'object';
export const renamed = (item) => (item.label ?? 'object') !== calledThen(item);
// Behind what is said of the last run, where that knew the thing by another name.
export const as = (item) => (renamed(item) ? ` as ${calledThen(item)}` : '');
// The model that the next run puts there, as far as the last one tells: nothing of what has another name by now.
export function standing(item) {
  const like = state.project.objects.find(({ mask }) => mask === item.like), { model } = made(item);
  if (item.model || like) return item.model ?? standing(like);
  return renamed(item) || item.banned.includes(model) ? null : model;
}
const round = (value) => Math.round(1000 * value) / 1000;
const centimetres = (value) => `${Math.round(100 * Math.abs(value))} cm`;

function sizes(item) {
  const now = item.size ?? made(item).size;
  get('metres').textContent = item.size || !now ? 'Metres' : `Metres, as placed${as(item)}`;
  ['width', 'depth', 'height'].forEach((name, k) => {
    if (document.activeElement !== get(name)) get(name).value = now ? round(now[k]) : '';
  });
}
function resize(item) {
  const typed = ['width', 'depth', 'height'].map((name) => (get(name).value && get(name).checkValidity() ? Number(get(name).value) : null));
  if (typed.every((value) => value)) edit(() => { item.size = typed; }); // else the others are to be typed yet
}

const front = (item) => item.front ?? made(item).front ?? 0;
function turn(item, degrees) {
  const to = front(item) + (degrees * Math.PI) / 180;
  edit(() => { item.front = round(Math.atan2(Math.sin(to), Math.cos(to))); });
}
function move(item, [farther, left], wide) {
  const by = wide ? 5 * STEP : STEP, [x, y] = item.nudge ?? [0, 0];
  const to = [round(x + by * farther), round(y + by * left)];
  edit(() => { item.nudge = to[0] || to[1] ? to : null; });
}
function moved(item) {
  const [x, y] = item.nudge ?? [0, 0];
  return [x && `${centimetres(x)} ${x > 0 ? 'farther' : 'nearer'}`, y && `${centimetres(y)} to the ${y > 0 ? 'left' : 'right'}`].filter(Boolean).join(', ') || 'as placed';
}

function choose(item, asset) {
  edit(() => {
    item.model = item.model === asset ? null : asset;
    item.pinned &&= Boolean(item.model);
    item.banned = item.banned.filter((name) => name !== asset);
    item.like = null;
  });
}
function ban(item, asset) {
  edit(() => {
    const banned = item.banned.includes(asset);
    item.banned = banned ? item.banned.filter((name) => name !== asset) : [...item.banned, asset];
    if (item.model === asset) Object.assign(item, { model: null, pinned: false });
  });
}

function model(item, one) {
  const entry = document.createElement('li'), picture = document.createElement('button'), not = document.createElement('button');
  const name = one.asset.replaceAll('_', ' '), banned = item.banned.includes(one.asset);
  const stands = !item.model && !item.like && made(item).model === one.asset;
  picture.type = not.type = 'button';
  if (one.picture) picture.append(Object.assign(new Image(), { src: one.picture, alt: '' }));
  picture.append(`${name} · ${one.distance.toFixed(2)}${one.rank ? ` · cousin ${one.rank}` : ''}${stands ? ' · stands there' : ''}`);
  picture.setAttribute('aria-pressed', String(item.model === one.asset));
  picture.title = 'This one';
  picture.dataset.asset = one.asset;
  picture.addEventListener('click', () => choose(item, one.asset));
  not.textContent = banned ? 'banned' : 'not this';
  not.setAttribute('aria-pressed', String(banned));
  not.setAttribute('aria-label', `${name}: not this one`);
  not.addEventListener('click', () => ban(item, one.asset));
  entry.append(picture, not);
  return entry;
}

async function ensure(item) {
  if (shown.has(item.mask)) return;
  shown.set(item.mask, []);
  try { shown.set(item.mask, (await ask('models', { mask: item.mask })).models); } catch (error) { state.trouble = error.message; }
  if (shown.get(item.mask).length) changed();
}

let drawn = ''; // what the list shows, so that it is made anew only when that changes
// As large as the model itself that will stand there.
const native = (item) => (shown.get(item.mask) ?? []).find((one) => one.asset === standing(item))?.size;
function ownSize(item) {
  const size = native(item);
  get('own-size').hidden = !size;
  if (size) get('own-size').textContent = `As its model: ${size.map((value, k) => `${Math.round(100 * value)} ${['wide', 'deep', 'high'][k]}`).join(' × ')}, cm`;
}

export function placement(item, others, nameOf) {
  sizes(item);
  get('front').textContent = item.front === null ? 'front as matched' : `front turned to ${Math.round((item.front * 180) / Math.PI)}°`;
  get('nudge').textContent = moved(item);
  ensure(item);
  const models = shown.get(item.mask) ?? [];
  ownSize(item);
  get('models').hidden = !models.length;
  get('models').querySelector('h2').textContent = `Another cousin${as(item)}`;
  get('like').replaceChildren(new Option('its own', ''), ...others.map((other) => new Option(nameOf(other), other.mask)));
  get('like').value = item.like ?? '';
  get('pinned').checked = item.pinned;
  get('pinned').disabled = !item.model;
  const now = JSON.stringify([item.mask, item.model, item.banned, item.like, models.length]);
  if (now === drawn) return;
  drawn = now;
  get('cousins').replaceChildren(...models.map((one) => model(item, one)));
}

export function bindPlacement(chosen) {
  for (const name of ['width', 'depth', 'height']) get(name).addEventListener('change', () => resize(chosen()));
  for (const button of document.querySelectorAll('[data-turn]')) button.addEventListener('click', () => turn(chosen(), Number(button.dataset.turn)));
  for (const button of document.querySelectorAll('[data-move]')) {
    button.addEventListener('click', (event) => move(chosen(), button.dataset.move.split(',').map(Number), event.shiftKey));
  }
  get('own-size').addEventListener('click', () => edit(() => { chosen().size = native(chosen()); }));
  get('pinned').addEventListener('change', ({ target }) => edit(() => { chosen().pinned = target.checked; }));
  get('like').addEventListener('change', ({ target }) => edit(() => {
    const item = chosen();
    item.like = target.value ? Number(target.value) : null;
    if (item.like) Object.assign(item, { model: null, pinned: false });
  }));
}
