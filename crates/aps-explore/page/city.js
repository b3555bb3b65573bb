// The map: houses, paths, and the two terminals to drag.

import { state } from './state.js';

/** Units of the picture along the longer side of the map. */
const SIDE = 520;
/** A finger finds a terminal this far from its middle. */
const GRIP = 22;
const NS = 'http://www.w3.org/2000/svg';

const svg = document.getElementById('map');
const part = id => document.getElementById(id);
const px = value => Math.round(value * 10) / 10;

let frame = { min: [0, 0], max: [1, 1], scale: SIDE };
let shown = null;

/** From metres to the picture, y upwards. */
export const place = ([x, y]) => [px((x - frame.min[0]) * frame.scale), px((frame.max[1] - y) * frame.scale)];

/** The place on the map under a pointer [m]. */
export function under(event) {
  const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  return [x / frame.scale + frame.min[0], frame.max[1] - y / frame.scale];
}

const path = points => 'M' + points.map(p => place(p).join(' ')).join('L');
export const outline = rings => rings.map(ring => path(ring) + 'Z').join('');

/** Draws the houses of a map. */
export function drawCity({ area: [min, max], rings }) {
  const size = [max[0] - min[0], max[1] - min[1]];
  frame = { min, max, scale: SIDE / Math.max(...size) };
  svg.setAttribute('viewBox', `0 0 ${px(size[0] * frame.scale)} ${px(size[1] * frame.scale)}`);
  part('outlines').setAttribute('d', outline(rings));
}

function terminal(end, name, colour) {
  const [x, y] = place(state[end]);
  const below = y < 30;
  const g = part(end);
  g.innerHTML = `<circle class="grip" cx="${x}" cy="${y}" r="${GRIP}"/><circle class="paper" cx="${x}" cy="${y}" r="8"/>`
    + `<circle class="fill-${colour}" cx="${x}" cy="${y}" r="6.5"/>`
    + `<text class="title halo fill-${colour}" text-anchor="middle" x="${Math.min(Math.max(x, 16), SIDE - 16)}" y="${below ? y + 24 : y - 12}">${name}</text>`;
  g.setAttribute('aria-valuetext', `x ${state[end][0]} m, y ${state[end][1]} m`);
}

export function drawTerminals() {
  const known = Boolean(state.tx && state.rx);
  for (const end of ['tx', 'rx']) part(end).toggleAttribute('hidden', !known);
  if (!known) return;
  terminal('tx', 'Tx', 's2');
  terminal('rx', 'Rx', 's1');
}

/** A point of a way, counted back from its end in units of the picture. */
function before(points, distance) {
  for (let i = points.length - 1; i > 0; i--) {
    const [[x0, y0], [x1, y1]] = [points[i], points[i - 1]];
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (distance <= length) return [x0 + (x1 - x0) * distance / length, y0 + (y1 - y0) * distance / length];
    distance -= length;
  }
  return points[0];
}

/** Draws the paths of a link: those that are listed one by one, all others as one. */
export function drawLink(answer) {
  shown = answer;
  const { paths, tx, rx } = answer.link;
  const points = i => [tx, ...paths[i].interactions.map(bend => bend.point), rx];
  const listed = new Set(answer.paths.map(p => p.index));
  part('rest').setAttribute('d', paths.map((_, i) => (listed.has(i) ? '' : path(points(i)))).join(''));
  let [rays, badges, ahead] = ['', '', 34];
  for (const p of answer.paths.toReversed()) {
    const isMaker = p.colour !== 'soft';
    rays += `<g data-path="${p.number}"><path class="line ${isMaker ? 'strong' : 'weak'} stroke-${p.colour}" d="${path(points(p.index))}"/>`;
    for (const bend of paths[p.index].interactions) {
      const [x, y] = place(bend.point);
      rays += `<circle class="bend ${bend.kind}" cx="${x}" cy="${y}" r="2.2"/>`;
    }
    rays += '</g>';
    if (isMaker) {
      const [x, y] = before(points(p.index).map(place), ahead).map(px);
      ahead += 13;
      badges += `<g data-path="${p.number}"><circle class="fill-${p.colour}" cx="${x}" cy="${y}" r="8"/>`
        + `<text class="number" text-anchor="middle" x="${x}" y="${y + 4}">${p.number}</text></g>`;
    }
  }
  part('rays').innerHTML = rays + badges;
}

export function clearLink() {
  shown = null;
  for (const id of ['rest', 'twin']) part(id).removeAttribute('d');
  part('rays').replaceChildren();
}

/** Shows from where the array seems to see a path besides its own direction. */
export function markTwin(number) {
  const found = shown?.paths.find(p => p.number === number && p.mirror_deg !== null);
  const twin = part('twin');
  if (!found) return twin.removeAttribute('d');
  const turn = (found.mirror_deg + shown.turn_deg) * Math.PI / 180;
  const [x, y] = shown.link.rx;
  const reach = 110 / frame.scale;
  twin.setAttribute('d', path([[x, y], [x + reach * Math.cos(turn), y + reach * Math.sin(turn)]]));
  twin.dataset.path = number;
}

/** Lets somebody drag the terminals, by pointer or by key, and put the receiver somewhere by a click. */
export function watchTerminals({ moved, isActive, snap }) {
  const tenths = p => p.map(v => Math.round(v * 10) / 10);
  const inside = p => p.map((v, i) => Math.min(Math.max(v, frame.min[i]), frame.max[i]));
  let dragged = null;
  let hasMoved = false;
  const put = (end, p, isOver) => {
    state[end] = inside(p);
    drawTerminals();
    moved(end, isOver);
  };
  // A drag may end without a click, which must not cost the next one.
  svg.addEventListener('pointerdown', () => { hasMoved = false; }, { capture: true });
  for (const end of ['tx', 'rx']) {
    const g = part(end);
    g.addEventListener('pointerdown', event => {
      if (!isActive() || event.button !== 0) return;
      const [x, y] = under(event);
      dragged = { end, offset: [state[end][0] - x, state[end][1] - y] };
      g.setPointerCapture(event.pointerId);
    });
    g.addEventListener('pointermove', event => {
      if (dragged?.end !== end) return;
      const [x, y] = under(event);
      hasMoved = true;
      put(end, tenths([x + dragged.offset[0], y + dragged.offset[1]]), false);
    });
    for (const kind of ['pointerup', 'pointercancel']) {
      g.addEventListener(kind, () => {
        if (dragged?.end === end && hasMoved) moved(end, true);
        dragged = null;
      });
    }
    g.addEventListener('keydown', event => {
      const way = arrow(event);
      if (way) put(end, tenths([state[end][0] + way[0], state[end][1] + way[1]]), true);
    });
  }
  svg.addEventListener('click', event => {
    const isFree = !event.target.closest('.terminal, #houses, #outlines');
    if (isActive() && isFree && !hasMoved && state.rx) put('rx', snap(under(event)) ?? tenths(under(event)), true);
  });
}

/** The step of an arrow key [m]. */
export function arrow(event) {
  const step = event.shiftKey ? 10 : 1;
  const way = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
  if (way) event.preventDefault();
  return way;
}

/** An element of the picture. */
export function element(name, attributes) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
