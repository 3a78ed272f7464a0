// What lies over the picture, as SVG.
import { area, dots, element, frame, line, name, unit } from './canvas.js';
import { marks } from './clicks.js';
import { drawOffers } from './offers.js';
import { find, isWall, nameOf, state } from './state.js';

// A handle is named `kind/which/point`; what it moves is found in tools.js.
function handle(name, [x, y]) {
  const kind = state.handle === name ? 'handle chosen' : 'handle';
  return element('circle', { cx: x, cy: y, r: 6 * unit(), class: kind, 'data-handle': name });
}
// An outline by hand has few points, which can be moved; that of a click has too many.
const isCoarse = (points) => points.length < 30 && Math.hypot(...[0, 1].map((k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k])))) > 12 * points.length * unit();
const near = (p) => p && Math.abs(p[0]) < 12 * state.project.width && Math.abs(p[1]) < 12 * state.project.height;

function camera() {
  const { perspective, scale } = state.project;
  const parts = [line(state.solved.horizon, 'horizon quiet')];
  const ends = perspective.horizon ?? state.solved.horizon;
  parts.push(handle('horizon/-/0', ends[0]), handle('horizon/-/1', ends[1]));
  for (const axis of 'xyz') if (near(state.solved.vanishing[axis])) parts.push(handle(`vanishing/${axis}/0`, perspective[axis] ?? state.solved.vanishing[axis]));
  perspective.guides.forEach((guide, k) => {
    parts.push(line([guide.a, guide.b], `guide ${guide.axis}${state.solved.weak[k] ? ' weak' : ''} quiet`), handle(`guide/${k}/a`, guide.a), handle(`guide/${k}/b`, guide.b));
  });
  if (scale.points && ['floor', 'upright'].includes(scale.kind)) {
    parts.push(line(scale.points, 'measure quiet'), handle('measure/-/0', scale.points[0]), handle('measure/-/1', scale.points[1]));
  }
  return parts;
}

// What the next click, or the object that is being drawn, stands or hangs on.
const carrying = (id) => ['box', 'round'].includes(state.tool) && (state.draft?.on ?? state.under) === id;

function walls(handles) {
  const parts = [];
  for (const [id, lines] of Object.entries(state.solved.walls)) {
    for (const ends of lines) parts.push(line(ends, `wall quiet${carrying(id) ? ' under' : ''}`));
    const drawn = handles && find(id);
    if (drawn) parts.push(handle(`wall/${id}/a`, drawn.a), handle(`wall/${id}/b`, drawn.b));
  }
  return parts;
}

const lowerLeft = (points) => points.reduce((one, other) => (other[0] - other[1] < one[0] - one[1] ? other : one));

function objects() {
  const parts = [], names = []; // names lie over all boxes
  const boxes = Object.entries(state.solved.boxes).sort(([, one], [, other]) => other.distance - one.distance);
  for (const [id, solid] of boxes) {
    const kind = id === 'draft' ? 'draft quiet' : carrying(id) ? 'under' : state.chosen === id ? 'chosen' : '';
    const item = find(id);
    const faces = solid.faces.map((face) => area(face, 'face'));
    parts.push(element('g', { class: item?.unsure ? `${kind} unsure` : kind, 'data-object': id }, faces));
    if (item?.label && solid.faces.length) names.push(name(nameOf(item), lowerLeft(solid.faces.flat())));
  }
  for (const one of state.project.objects) {
    const kind = state.chosen === one.id ? 'outline quiet' : 'outline quiet other';
    for (const points of [one.outline ?? [], ...one.pieces ?? []]) if (points.length > 2) parts.push(area(points, kind));
  }
  parts.push(...drawOffers(), ...names);
  const item = state.chosen && !isWall(state.chosen) ? find(state.chosen) : null;
  if (item && state.step === 'objects') {
    item.points.forEach((point, k) => parts.push(handle(`object/${item.id}/${k}`, point)));
    if (isCoarse(item.outline ?? [])) (item.outline ?? []).forEach((point, k) => parts.push(handle(`outline/${item.id}/${k}`, point)));
  }
  return parts;
}

function draft() {
  const points = state.draft?.points ?? [];
  if (state.draft?.kind === 'frame') return [frame(points)];
  const parts = points.map(([x, y]) => element('circle', { cx: x, cy: y, r: 3 * unit(), class: 'handle quiet' }));
  if (points.length > 1 && state.draft.kind !== 'box') {
    parts.push(element('polyline', { points: points.map((p) => p.join()).join(' '), class: 'measure quiet' }));
  }
  return parts;
}

export function draw() {
  const over = document.getElementById('over');
  document.getElementById('view').classList.toggle('selecting', state.tool === 'select');
  if (!over || !state.solved) return;
  const grid = state.grid && state.step !== 'write' ? state.solved.grid.map((ends) => line(ends, 'grid quiet')) : [];
  const parts = [...grid, ...walls(state.step === 'walls'), ...(state.step === 'camera' ? [] : objects())];
  over.replaceChildren(...parts, ...(state.step === 'camera' ? camera() : []), ...draft(), ...dots(marks()));
}
