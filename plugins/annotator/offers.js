// What was found and left out of the scene or drawing: dashed outlines with a guess, of which a click takes one.
import { area, corner, element, name } from './canvas.js';
import { state } from './state.js';

const get = (id) => document.getElementById(id);
export const blank = (id, mask) => ({ id, mask, label: null, named: false, around: null, outline: [], pieces: [], layer: 0, joins: [], articulated: null, doors: null, drawers: null, panels: null, mounting: null, on: null, size: null, front: null, nudge: null, model: null, pinned: false, banned: [], like: null });

// On the drawing page they are part of the drawing: { id, text, why, outlines }, on the other one with `mask` and more.
const guessed = ({ id, names, outline, pieces, left_out: why }) => ({
  id, text: `${names[0].name}, ${Math.round(100 * names[0].probability)} %`, why, outlines: [outline, ...pieces].filter((points) => points.length > 2),
});
const offers = () => state.project.left_out?.map(guessed) ?? state.offers.filter(({ mask }) => !state.project.objects.some((item) => item.mask === mask || item.joins.includes(mask)));

// The thing that a click on an offer makes of it: with its first name.
export function taken(mask) {
  const { id, label, articulated } = state.offers.find((offer) => offer.mask === mask);
  return { ...blank(id, mask), label, articulated };
}

export function drawOffers() {
  return offers().flatMap((offer) => {
    const kind = `offer ${state.chosen === offer.id ? 'chosen' : ''}`.trim();
    const about = element('title', {}, [`${offer.text}: ${offer.why}. Click to take it.`]);
    const outlines = offer.outlines.map((points) => area(points, 'face'));
    return [element('g', { class: kind, 'data-offer': offer.mask ?? offer.id }, [about, ...outlines]), name(`${offer.text}?`, corner(offer.outlines))];
  });
}

export function listOffers(take) {
  const lines = offers().map((offer) => {
    const entry = document.createElement('li'), button = document.createElement('button');
    button.type = 'button';
    button.textContent = `${offer.text}: ${offer.why}`;
    button.setAttribute('aria-pressed', String(state.chosen === offer.id));
    button.addEventListener('click', () => take(offer.mask ?? offer.id));
    entry.append(button);
    return entry;
  });
  get('left-out').hidden = !lines.length;
  get('left-out').querySelector('summary').textContent = `Left out: ${lines.length}; a click takes one`;
  get('left-out').querySelector('ul').replaceChildren(...lines);
}
