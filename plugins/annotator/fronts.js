// Doors and drawers as boxes on the front of a thing, seen straight on: drawn, moved, resized, laid out, deleted.
import { element } from './canvas.js';
import { ask, edit, remember, state, touch } from './state.js';

const get = (id) => document.getElementById(id);
get('front-view').innerHTML = `<summary></summary>
  <p id="front-hint" class="facts"></p>
  <svg id="front-picture" tabindex="0" role="application" aria-label="Its front, seen straight on, to draw on"></svg>
  <div class="row">
    <button type="button" data-kind="door">Door</button>
    <button type="button" data-kind="drawer">Drawer</button>
    <button type="button" id="lay-out" title="as many as are counted, one beside or above the other">Lay out evenly</button>
    <button type="button" id="no-panel" title="Delete">Delete the box</button>
  </div>`;
const svg = get('front-picture');
const SNAP = 0.015, SMALLEST = 0.02; // shares of the front
const SIDES = { left: 'x', right: 'x', bottom: 'y', top: 'y' };
const HANDLES = [['left', 'bottom'], ['right', 'bottom'], ['left', 'top'], ['right', 'top'], ['left'], ['right'], ['bottom'], ['top']];
let view = null, asked = '', kind = 'drawer', at = null, press = null, chosen = () => null, bodyOf = null;

const round = (value) => Math.round(10000 * Math.min(1, Math.max(0, value))) / 10000;
const opens = (item) => item.articulated || item.doors + item.drawers > 0;
const panels = () => chosen()?.panels ?? [];

// Boxes say how many doors and drawers there are, too.
function counted(item) {
  item.doors = item.panels.filter((panel) => panel.kind === 'door').length;
  item.drawers = item.panels.length - item.doors;
  item.articulated = true;
}
// A typed number says that boxes which were drawn are not right any more.
export function typed(item, name, count) {
  if (item[name] !== count && item.panels?.length) item.panels = [];
  item[name] = count;
  item.articulated = item.doors + item.drawers > 0;
}
export function closed(item) { Object.assign(item, { articulated: false, doors: 0, drawers: 0 }, item.panels?.length ? { panels: [] } : {}); }

function evenly(item) {
  const row = (name, count, bottom, top) => Array.from({ length: count }, (_, k) => ({ kind: name, left: round(k / count), right: round((k + 1) / count), bottom, top }));
  const stack = (count) => Array.from({ length: count }, (_, k) => ({ kind: 'drawer', left: 0, right: 1, bottom: round(1 - (k + 1) / count), top: round(1 - k / count) }));
  return item.doors ? [...row('drawer', item.drawers, 0.75, 1), ...row('door', item.doors, 0, item.drawers ? 0.75 : 1)] : stack(item.drawers);
}

function share(event) {
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  return { x: point.x / view.width, y: 1 - point.y / view.height };
}
// An edge near another one, or near the border, is meant to be there.
function snapped(value, axis, own) {
  const ends = Object.keys(SIDES).filter((side) => SIDES[side] === axis);
  const edges = [0, 1, ...panels().flatMap((panel, k) => (k === own ? [] : ends.map((side) => panel[side])))];
  return round(edges.find((edge) => Math.abs(edge - value) < SNAP) ?? value);
}

async function look(item) {
  const now = JSON.stringify([item.mask ?? item.id, item.front ?? item.faces, item.points ?? item.around ?? item.outline, item.width, item.height]);
  if (now === asked) return;
  asked = now;
  try {
    const answer = await ask('front', bodyOf(item));
    if (asked === now) view = answer; // else another one was asked for since
  } catch { if (asked === now) { view = null; asked = ''; } }
  draw();
}

function draw() {
  svg.toggleAttribute('hidden', !view);
  if (!view) return;
  const { width, height, picture } = view, parts = [];
  svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
  if (picture) parts.push(element('image', { href: picture, width, height }));
  const unit = Math.max(width / Math.max(1, svg.clientWidth), height / Math.max(1, svg.clientHeight)), numbers = { door: 0, drawer: 0 };
  panels().forEach((panel, k) => {
    const [x, y] = [panel.left * width, (1 - panel.top) * height];
    numbers[panel.kind] += 1;
    parts.push(element('rect', { x, y, width: (panel.right - panel.left) * width, height: (panel.top - panel.bottom) * height, class: `panel ${panel.kind}${k === at ? ' chosen' : ''}`, 'data-panel': k }));
    parts.push(element('text', { x: x + 4 * unit, y: y + 14 * unit, 'font-size': 12 * unit }, [`${panel.kind} ${numbers[panel.kind]}`]));
  });
  const one = panels()[at];
  if (one) {
    for (const sides of HANDLES) {
      const place = (axis, low, high) => one[sides.find((side) => SIDES[side] === axis)] ?? (one[low] + one[high]) / 2;
      parts.push(element('circle', { cx: place('x', 'left', 'right') * width, cy: (1 - place('y', 'bottom', 'top')) * height, r: 5 * unit, class: 'handle', 'data-sides': sides.join(' ') }));
    }
  }
  svg.replaceChildren(...parts);
}

export function front(item) {
  const box = get('front-view'), drawn = item.panels?.length ?? 0;
  if (box.dataset.of !== (item.mask ?? item.id).toString()) {
    Object.assign(box.dataset, { of: item.mask ?? item.id });
    at = null;
    kind = item.doors && !item.drawers ? 'door' : 'drawer';
    box.open = drawn > 0;
  }
  box.hidden = !opens(item);
  box.querySelector('summary').textContent = drawn ? `Where they are on its front: ${drawn} drawn` : 'Where they are on its front: not given';
  get('lay-out').disabled = !(item.doors + item.drawers);
  get('no-panel').disabled = !panels()[at];
  for (const button of document.querySelectorAll('[data-kind]')) button.setAttribute('aria-pressed', String(button.dataset.kind === (panels()[at]?.kind ?? kind)));
  get('front-hint').textContent = view && !view.picture
    ? 'Its front is not seen in the picture. If it is, turn the front; else draw from memory.'
    : 'Press at one corner of a door or drawer, let go at the opposite one. Drag a box or its edges.';
  if (box.hidden || !box.open) return;
  look(item);
  draw();
}

function change(act) { edit(() => { const item = chosen(); item.panels ??= []; act(item); counted(item); }); }
function remove() {
  if (!panels()[at]) return;
  const gone = at;
  at = null;
  change((item) => item.panels.splice(gone, 1));
}

function down(event) {
  if (event.button !== 0 || !view) return;
  svg.focus({ preventScroll: true });
  svg.setPointerCapture(event.pointerId);
  const { sides, panel } = event.target.dataset, from = share(event);
  if (!sides) at = panel === undefined ? null : Number(panel);
  press = { from, sides: sides?.split(' '), before: { ...panels()[at] }, drawing: at === null, moved: false };
  front(chosen());
}
function dragged(event) {
  if (!press) return;
  const to = share(event), item = chosen(), [dx, dy] = [to.x - press.from.x, to.y - press.from.y];
  if (!press.moved && Math.hypot(dx, dy) < SMALLEST) return;
  if (!press.moved) { remember(); press.moved = true; item.panels ??= []; }
  if (press.drawing) {
    const [x0, x1] = [press.from.x, to.x].sort((a, b) => a - b), [y0, y1] = [press.from.y, to.y].sort((a, b) => a - b);
    const box = { left: snapped(x0, 'x', at), right: snapped(x1, 'x', at), bottom: snapped(y0, 'y', at), top: snapped(y1, 'y', at) };
    if (box.right - box.left < SMALLEST || box.top - box.bottom < SMALLEST) return;
    if (at === null) at = item.panels.push({ kind }) - 1;
    Object.assign(item.panels[at], box);
    counted(item); // an earlier change may be saved while this is drawn
  } else if (press.sides) {
    for (const side of press.sides) {
      const value = snapped(press.before[side] + (SIDES[side] === 'x' ? dx : dy), SIDES[side], at), { left, right, bottom, top } = press.before;
      const [low, high] = { left: [0, right - SMALLEST], right: [left + SMALLEST, 1], bottom: [0, top - SMALLEST], top: [bottom + SMALLEST, 1] }[side];
      item.panels[at][side] = round(Math.min(high, Math.max(low, value)));
    }
  } else shift(item.panels[at], press.before, dx, dy);
  draw();
}
function shift(panel, from, dx, dy) {
  const x = Math.min(1 - from.right, Math.max(-from.left, dx)), y = Math.min(1 - from.top, Math.max(-from.bottom, dy));
  Object.assign(panel, { left: round(from.left + x), right: round(from.right + x), bottom: round(from.bottom + y), top: round(from.top + y) });
}
function up() {
  const done = press;
  press = null;
  if (!done?.moved || at === null) return;
  counted(chosen());
  touch();
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
function key(event) {
  if (event.ctrlKey || event.metaKey || !panels()[at]) return;
  if (event.key === 'Delete' || event.key === 'Backspace') remove();
  else if (event.key === 'Escape') { at = null; front(chosen()); }
  else if (ARROWS[event.key]) {
    const [dx, dy] = ARROWS[event.key].map((value) => value * (event.shiftKey ? 0.05 : 0.01));
    change((item) => shift(item.panels[at], { ...item.panels[at] }, dx, dy));
  } else return;
  event.preventDefault();
  event.stopPropagation(); // else the thing is deleted or moved
}

export function bindFront(which, body) {
  chosen = which;
  bodyOf = body;
  svg.addEventListener('pointerdown', down);
  svg.addEventListener('pointermove', dragged);
  svg.addEventListener('pointerup', up);
  svg.addEventListener('keydown', key);
  svg.addEventListener('mousedown', (event) => event.preventDefault());
  for (const button of document.querySelectorAll('[data-kind]')) {
    button.addEventListener('click', () => {
      kind = button.dataset.kind;
      if (panels()[at]) change((item) => { item.panels[at].kind = kind; });
      else front(chosen());
    });
  }
  get('lay-out').addEventListener('click', () => { at = null; change((item) => { item.panels = evenly(item); }); });
  get('no-panel').addEventListener('click', remove);
  get('front-view').addEventListener('toggle', () => { if (chosen()) front(chosen()); });
}
