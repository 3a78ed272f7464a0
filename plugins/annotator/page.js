// The panel beside the picture, and the start.
import { bindFrame, proposal } from './both.js';
import * as clicks from './clicks.js';
import { ask, carried, changed, copy, edit, find, freeId, isWall, nameOf, onChange, remove, solve, state, undoable } from './state.js';
import { begin } from './canvas.js';
import { bindFront, closed, front, typed } from './fronts.js';
import { draw } from './drawing.js';
import { listOffers } from './offers.js';
import { named, take } from './outlining.js';
import { choose, hint, step } from './tools.js';

const SIDES = ['wide', 'deep', 'high'];
const get = (id) => document.getElementById(id);
const metres = (value) => `${value < 0.995 ? `${(100 * value).toFixed(value < 0.1 ? 1 : 0)} cm` : `${value.toFixed(2)} m`}`;
// Width, depth and height in place of those that are absurd; what the picture tells well stays.
const usualOf = (item) => state.solved?.usual[item.id]?.map((side, k) => side ?? state.solved.boxes[item.id].size[k]);
const chosen = () => (state.chosen && !isWall(state.chosen) ? find(state.chosen) : null);

function options(select, entries, value) {
  const wanted = JSON.stringify(entries);
  if (select.dataset.entries !== wanted) {
    select.dataset.entries = wanted;
    select.replaceChildren(...entries.map(([key, text]) => new Option(text, key)));
  }
  if (document.activeElement !== select || select.value !== value) select.value = value;
}
function fill(id, value, placeholder) {
  const field = get(id);
  if (document.activeElement !== field) field.value = value ?? '';
  if (placeholder !== undefined) field.placeholder = placeholder;
}
function list(parent, items, text) {
  parent.replaceChildren(...items.map((item) => {
    const entry = document.createElement('li'), button = document.createElement('button'), note = document.createElement('span');
    button.textContent = text(item);
    button.setAttribute('aria-pressed', String(state.chosen === item.id));
    button.addEventListener('click', () => { state.chosen = item.id; state.handle = isWall(item.id) ? `wall/${item.id}/a` : null; changed(); });
    note.className = 'note';
    note.textContent = item === chosen() ? '' : state.solved?.notes[item.id] ?? ''; // the chosen one's stands below
    entry.append(button, note);
    return entry;
  }));
}

function panel() {
  const { project, solved } = state;
  for (const tab of document.querySelectorAll('[data-step]')) tab.setAttribute('aria-selected', String(tab.dataset.step === state.step));
  for (const part of document.querySelectorAll('[data-panel]')) part.hidden = part.dataset.panel !== state.step;
  for (const tool of document.querySelectorAll('[data-tool]')) tool.setAttribute('aria-pressed', String(tool.dataset.tool === state.tool));
  [get('undo').disabled, get('redo').disabled] = undoable().map((possible) => !possible);
  get('hint').textContent = hint();
  get('trouble').textContent = state.trouble;
  get('trouble').hidden = !state.trouble;
  if (!solved) return;

  const { camera } = solved;
  get('camera-facts').textContent = `${camera.across}° across, tilted ${camera.pitch}°, rolled ${camera.roll}°, ${metres(camera.above)} above the floor`;
  const weak = solved.weak.filter(Boolean).length;
  get('weak').hidden = !weak;
  get('weak').textContent = `${weak} of ${solved.weak.length} lines (dotted) do not run as the camera says: move or delete them.`;
  fill('across', project.perspective.focal ? (2 * Math.atan(project.width / 2 / project.perspective.focal) * 180 / Math.PI).toFixed(1) : '');
  get('scale-kind').querySelector('[value=depth]').hidden = !state.depth;
  fill('scale-kind', project.scale.kind);
  fill('scale-metres', project.scale.kind === 'depth' ? '' : project.scale.metres, 'unknown: 1.5');
  const { factor } = camera;
  get('camera-doubt').hidden = !factor;
  if (factor) {
    const height = (camera.above * factor).toFixed(2), times = Math.max(factor, 1 / factor).toFixed(2);
    get('camera-doubt').querySelector('span').textContent = `What is drawn comes out ${times} times too ${factor < 1 ? 'high' : 'low'}: is the camera ${height} m above the floor, and not ${camera.above} m?`;
    get('take-height').textContent = `Take ${height} m`;
    get('keep-height').textContent = `It is ${camera.above} m`;
  }
  get('scale-metres').disabled = project.scale.kind === 'depth';

  get('scale-which').hidden = project.scale.kind !== 'object';
  get('measure').hidden = !['floor', 'upright'].includes(project.scale.kind);
  options(get('scale-object'), project.objects.map((item) => [item.id, nameOf(item)]), project.scale.object ?? '');
  fill('scale-side', project.scale.side);

  list(get('walls'), project.walls, (item) => item.id.replace('_', ' '));
  get('behind').hidden = !chosen();
  list(get('objects'), project.objects, (item) => {
    const size = solved.boxes[item.id]?.size;
    return size ? `${nameOf(item)}: ${size.map((side, k) => `${metres(side)} ${SIDES[k]}`).join(' × ')}` : nameOf(item);
  });
  listOffers(take);
  const carriers = [['floor', 'the floor'], ...project.walls.map((item) => [item.id, item.id.replace('_', ' ')])];
  const others = project.objects.map((item) => [item.id, nameOf(item)]);
  if (state.next !== 'auto' && state.next !== 'floor' && !find(state.next)) state.next = 'auto';
  options(get('next-on'), [['auto', 'what is there'], ...carriers, ...others], state.next);

  const item = chosen();
  get('object').hidden = !item;
  if (!item) return;
  fill('label', item.label);
  get('proposals').replaceChildren(...(state.proposals[item.id] ?? item.names?.map((one) => one.name) ?? []).map((text) => proposal(text, item.label === text, () => { edit(() => { item.label = text; }); named(item); })));
  options(get('on'), [...carriers, ...others.filter(([id]) => id !== item.id)], item.on);
  fill('doors', item.doors || 0);
  fill('drawers', item.drawers || 0);
  get('articulated').checked = Boolean(item.articulated || item.doors || item.drawers);
  for (const id of ['free', 'round']) get(id).checked = Boolean(item[id]);
  fill('faces', item.faces ?? 'front');
  front(item);
  const box = solved.boxes[item.id];
  ['width', 'depth', 'height'].forEach((side, k) => fill(side, item[side], box ? box.size[k].toFixed(3) : ''));
  get('boxed').hidden = !item.outline?.length;
  get('object-doubt').textContent = solved.notes[item.id] ?? '';
  get('object-facts').textContent = box ? `${metres(box.distance)} away` : '';
  get('right').hidden = !item.unsure;
  const beneath = find(solved.beneath[item.id]);
  get('put-on').hidden = !beneath;
  if (beneath) get('put-on').textContent = `Put it on ${nameOf(beneath)}`;
  const usual = usualOf(item);
  get('usual').hidden = !usual;
  if (usual) get('usual').textContent = `Use the usual size: ${usual.map((side, k) => `${Math.round(100 * side)} ${SIDES[k]}`).join(' × ')}, cm`;
}

// A side that is now the known length is as long as it was, until another length is typed.
function asDrawn(scale) {
  const size = scale.kind === 'object' && state.solved.boxes[scale.object]?.size;
  if (size) scale.metres = size[['width', 'depth', 'height'].indexOf(scale.side)];
}

const number = (field) => (field.value === '' || !field.checkValidity() ? null : Number(field.value));
function field(id, change) {
  get(id).addEventListener('change', (event) => { const target = event.target; edit((project) => change(project, target, chosen())); });
}

function bind() {
  for (const tab of document.querySelectorAll('[data-step]')) tab.addEventListener('click', () => step(tab.dataset.step));
  for (const tool of document.querySelectorAll('[data-tool]')) tool.addEventListener('click', () => choose(tool.dataset.tool));
  bindFrame(() => { showResult(); get('result').onload = ({ target }) => target.scrollIntoView({ block: 'end' }); });
  get('grid').addEventListener('change', (event) => { state.grid = event.target.checked; draw(); });
  field('across', (project, target) => {
    const degrees = number(target);
    project.perspective.focal = degrees ? project.width / 2 / Math.tan(degrees * Math.PI / 360) : null;
  });
  get('unpin').addEventListener('click', () => edit((project) => Object.assign(project.perspective, { horizon: null, x: null, y: null, z: null, focal: null })));
  get('propose').addEventListener('click', () => edit((project) => { project.perspective = copy(state.fresh.perspective); }));
  field('scale-kind', ({ scale }, target, item) => {
    if (target.value === 'camera') scale.metres = state.solved.camera.above;
    if ('floor upright'.includes(target.value) && target.value !== scale.kind) scale.points = null; // another line
    scale.kind = target.value;
    scale.object ??= (item ?? state.project.objects[0])?.id ?? null;
    asDrawn(scale);
  });
  field('scale-object', ({ scale }, target) => { scale.object = target.value; asDrawn(scale); });
  field('scale-side', ({ scale }, target) => { scale.side = target.value; asDrawn(scale); });
  field('scale-metres', ({ scale }, target) => { scale.metres = number(target) ?? (scale.kind === 'camera' ? null : scale.metres); });
  get('take-height').addEventListener('click', () => edit(({ scale }) => { scale.metres = Number((state.solved.camera.above * state.solved.camera.factor).toFixed(2)); }));
  get('keep-height').addEventListener('click', () => edit(({ scale }) => { scale.metres = state.solved.camera.above; }));
  get('right').addEventListener('click', () => edit(() => { chosen().unsure = false; }));
  get('put-on').addEventListener('click', () => edit(() => carried(chosen(), state.solved.beneath[state.chosen])));
  get('usual').addEventListener('click', () => edit(() => {
    const sides = state.solved.usual[state.chosen] ?? [];
    ['width', 'depth', 'height'].forEach((side, k) => { if (sides[k]) chosen()[side] = sides[k]; });
  }));
  get('next-on').addEventListener('change', ({ target }) => { state.next = target.value; });
  get('behind').addEventListener('click', () => {
    const foot = state.solved.boxes[state.chosen]?.foot;
    if (foot) edit((project) => project.walls.push({ id: freeId('wall'), a: foot[0], b: foot[1], free: Boolean(chosen().free) }));
  });
  field('label', (_, target, item) => { item.label = target.value.trim(); named(item); });
  get('by-clicks').addEventListener('click', () => { choose('click'); clicks.go(chosen()); changed(); });
  field('faces', (_, target, item) => { item.faces = target.value; });
  field('on', (_, target, item) => carried(item, target.value));
  for (const id of ['doors', 'drawers']) field(id, (_, target, item) => typed(item, id, number(target) ?? 0));
  field('articulated', (_, target, item) => { if (target.checked) item.articulated = true; else closed(item); });
  for (const id of ['free', 'round']) field(id, (_, target, item) => { item[id] = target.checked; });
  for (const id of ['width', 'depth', 'height']) field(id, (_, target, item) => { item[id] = number(target); });
  bindFront(chosen, (item) => ({ project: state.project, id: item.id }));
  get('boxed').addEventListener('click', () => edit(() => { Object.assign(chosen(), { outline: [], pieces: [] }); }));
  get('delete').addEventListener('click', () => remove(state.chosen));
}

function showResult() {
  get('result').src = `made.png?${Date.now()}`;
  get('result').hidden = false;
}

async function start() {
  const answer = await ask('start');
  Object.assign(state, { project: answer.project, fresh: answer.fresh, depth: answer.depth });
  get('title').textContent = document.title = answer.project.picture;
  get('folder').textContent = answer.folder;
  get('other').hidden = !answer.other;
  get('categories').replaceChildren(...answer.categories.map((name) => new Option(name)));
  if (answer.project.objects.length) state.step = 'objects';
  begin();
  bind();
  onChange(panel);
  onChange(draw);
  if (answer.pictured) showResult();
  await solve();
  clicks.offer(answer.clicks);
  if (answer.notes.length) get('saved').textContent = answer.notes.join(' ');
}
start().catch((error) => { get('trouble').textContent = error.message; get('trouble').hidden = false; });
