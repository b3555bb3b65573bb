// Houses drawn, moved and taken away.

import { arrow, element, outline, place, under } from './city.js';
import { isChanged, none, state } from './state.js';

const part = id => document.getElementById(id);
const svg = part('map');
const whole = p => p.map(Math.round);

let city = { houses: [], as_read: 0 };
let past = [];
let ring = [];
let chosen = null;
let mode = 'link';
/** Place of the cross that draws a house by keys [m]. */
let cross = null;
let changed = () => {};

const copy = () => structuredClone(state.houses);

/** Changes the houses; the state before can be called back. */
function change(edit) {
  past.push(copy());
  edit(state.houses);
  changed();
  tools();
}

/** Calls the last change back; false when there is none. */
export function undo() {
  if (!past.length) return false;
  state.houses = past.pop();
  changed();
  tools();
  return true;
}

/** Forgets what was done, for another map. */
export function forget() {
  [past, ring, chosen] = [[], [], null];
  tools();
}

function move(id, [dx, dy]) {
  if (!dx && !dy) return;
  change(houses => {
    const drawn = houses.drawn[id - city.as_read];
    if (drawn) return void (houses.drawn[id - city.as_read] = drawn.map(([x, y]) => [x + dx, y + dy]));
    const known = houses.moved.find(entry => entry[0] === id);
    if (known) known[1] = [known[1][0] + dx, known[1][1] + dy];
    else houses.moved.push([id, [dx, dy]]);
  });
}

function remove(id) {
  chosen = null;
  // A second key before the map answers must not take the next one.
  part('houses').querySelector(`[data-house="${id}"]`)?.remove();
  change(houses => {
    if (id >= city.as_read) houses.drawn.splice(id - city.as_read, 1);
    else {
      houses.moved = houses.moved.filter(entry => entry[0] !== id);
      houses.gone.push(id);
    }
  });
}

function finish() {
  const points = ring;
  ring = [];
  sketch();
  if (points.length > 2) change(houses => houses.drawn.push(points));
  tools();
}

/** Draws the corners so far, and the side to a place that may become the next. */
function sketch(next) {
  const d = [...ring, ...(ring.length && next ? [next] : [])].map(place).map(p => p.join(' ')).join('L');
  part('drawing').setAttribute('d', d && `M${d}`);
}

/** Sets a corner; the first one again ends the house. */
function corner(point) {
  const isClosed = ring.length > 2 && Math.hypot(point[0] - ring[0][0], point[1] - ring[0][1]) < 3;
  if (isClosed) return finish();
  ring.push(point);
  sketch();
  tools();
}

/** Puts the cross somewhere on the map; it is there while houses are drawn. */
function crossTo(p) {
  const isShown = mode === 'draw' && Boolean(city.area);
  part('cross').toggleAttribute('hidden', !isShown);
  if (!isShown) return;
  const [min, max] = city.area;
  cross = whole(p).map((v, i) => Math.min(Math.max(v, min[i]), max[i]));
  const [x, y] = place(cross);
  part('cross').setAttribute('d', `M${x - 9} ${y}h18M${x} ${y - 9}v18`);
  part('cross').setAttribute('aria-valuetext', `x ${cross[0]} m, y ${cross[1]} m`);
  sketch(cross);
}

function tools() {
  part('undo').disabled = !past.length;
  part('reset').disabled = !isChanged(state.houses);
  part('finish').hidden = ring.length < 3;
  part('remove').hidden = mode !== 'houses' || chosen === null;
}

/** Lays something to take hold of over every house. */
export function drawHouses(answer) {
  city = answer;
  const focused = document.activeElement?.dataset?.house;
  const shapes = mode === 'houses' ? city.houses.map(house => {
    const shape = element('path', {
      d: outline(house.rings), 'data-house': house.id, tabindex: 0, role: 'button', 'fill-rule': 'evenodd', 'aria-label': `House ${house.id}`,
    });
    shape.classList.toggle('is-chosen', house.id === chosen);
    return shape;
  }) : [];
  part('houses').replaceChildren(...shapes);
  if (focused !== undefined) part('houses').querySelector(`[data-house="${focused}"]`)?.focus({ preventScroll: true });
  crossTo(cross ?? state.rx ?? [0, 0]);
  tools();
}

function choose(shape) {
  chosen = shape ? Number(shape.dataset.house) : null;
  for (const one of part('houses').children) one.classList.toggle('is-chosen', one === shape);
  tools();
}

/** Listens to the tools; `then` is called after each change. */
export function watchHouses(then) {
  changed = then;
  let held = null;
  for (const radio of document.querySelectorAll('input[name=mode]')) {
    radio.addEventListener('change', () => {
      [mode, ring] = [radio.value, []];
      svg.classList.toggle('draw', mode === 'draw');
      svg.classList.toggle('is-editing', mode !== 'link');
      sketch();
      choose(null);
      drawHouses(city);
    });
  }
  part('houses').addEventListener('pointerdown', event => {
    const shape = event.target.closest('[data-house]');
    if (!shape || event.button !== 0) return;
    choose(shape);
    held = { shape, from: under(event) };
    shape.setPointerCapture(event.pointerId);
  });
  const way = event => whole(under(event).map((v, i) => v - held.from[i]));
  part('houses').addEventListener('pointermove', event => {
    if (!held) return;
    const [x0, y0] = place([0, 0]);
    const [x1, y1] = place(way(event));
    held.shape.setAttribute('transform', `translate(${x1 - x0} ${y1 - y0})`);
  });
  part('houses').addEventListener('pointerup', event => {
    if (held) move(Number(held.shape.dataset.house), way(event));
    held = null;
  });
  part('houses').addEventListener('pointercancel', () => {
    held?.shape.removeAttribute('transform');
    held = null;
  });
  part('houses').addEventListener('focusin', event => choose(event.target));
  part('houses').addEventListener('keydown', event => {
    const id = Number(event.target.dataset.house);
    const by = arrow(event);
    if (by) move(id, by);
    if (event.key === 'Delete') remove(id);
  });
  svg.addEventListener('click', event => { if (mode === 'draw') corner(whole(under(event))); });
  svg.addEventListener('pointermove', event => { if (ring.length) sketch(whole(under(event))); });
  part('cross').addEventListener('keydown', event => {
    const by = arrow(event);
    if (by) crossTo(cross.map((v, i) => v + by[i]));
    if (event.key !== ' ') return;
    event.preventDefault();
    corner(cross);
  });
  document.addEventListener('keydown', event => {
    if (event.key === 'Escape') { ring = []; sketch(); tools(); }
    if (event.key === 'Enter' && ring.length > 2 && event.target.tagName !== 'BUTTON') finish();
    const isText = /^(INPUT|SELECT)$/.test(event.target.tagName) && !/^(radio|checkbox|range)$/.test(event.target.type);
    if (event.key === 'z' && (event.ctrlKey || event.metaKey) && !isText && undo()) event.preventDefault();
  });
  part('finish').addEventListener('click', finish);
  part('remove').addEventListener('click', () => remove(chosen));
  part('undo').addEventListener('click', undo);
  part('reset').addEventListener('click', () => change(() => { state.houses = none(); }));
}

export const isDrawing = () => mode !== 'link';
