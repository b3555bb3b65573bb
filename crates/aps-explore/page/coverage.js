// A quantity over the whole map, painted while it comes in.

import { ask, Fault } from './ask.js';
import { cityQuestion, settingsQuestion, state } from './state.js';

/** Cells along the longer side. */
const CELLS = 128;

const part = id => document.getElementById(id);
const canvas = part('heat');

/** Steps of the scale of strengths, as the theme has them. */
function strengths() {
  const style = getComputedStyle(document.documentElement);
  return [...Array(8).keys()].map(i => style.getPropertyValue(`--g${i}`).trim())
    .map(hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16)));
}

/** Colour of a part of the scale, 0 to 1. */
function between(steps, part) {
  const at = Math.min(Math.max(part, 0), 1) * (steps.length - 1);
  const low = Math.min(Math.floor(at), steps.length - 2);
  return steps[low].map((v, i) => v + (steps[low + 1][i] - v) * (at - low));
}

/** Colour of a direction, 0 to 1 around. */
function around(turn) {
  return [0, 1 / 3, 2 / 3].map(shift => 128 + 110 * Math.cos(2 * Math.PI * (turn - shift)));
}

/** For each quantity: its name in the answer, its values on a scale, and the ends of the scale in words. */
const KINDS = {
  level: { of: 'level_db', span: 130, ends: ([low, high]) => [`${low.toFixed(0)} dB`, `${high.toFixed(0)} dB`] },
  paths: { of: 'paths', scale: Math.log1p, ends: ([low, high]) => [low, high].map(v => Math.expm1(v).toFixed(0)) },
  sight: { of: 'sight', ends: () => ['no', 'line of sight'], range: [0, 1] },
  direction: { of: 'direction_deg', isRound: true, ends: () => ['−180°', '180°'], range: [-180, 180] },
  error: { of: 'error_db', ends: () => ['0 dB', '10 dB'], range: [0, 10] },
};

let run = null;
let grid = null;
let values = null;

/** The middle of the cell at a place, for whoever clicks on one; none without coverage. */
export function snap([x, y]) {
  if (!state.show || !grid) return null;
  const middle = (v, i) => grid.min[i] + (Math.floor((v - grid.min[i]) / grid.cell_m) + grid.middle) * grid.cell_m;
  return [x, y].map(middle);
}

export const isRunning = () => run !== null;

export function stop() {
  run?.abort();
  run = null;
  part('progress').hidden = true;
}

export function clear() {
  stop();
  [grid, values] = [null, null];
  canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
  part('legend').hidden = true;
  part('map').classList.remove('is-covered');
}

/** Asks for the quantity that is chosen and paints it as it comes. */
export async function start(fail) {
  stop();
  const kind = KINDS[state.show];
  if (!kind || !state.tx || !part('map').viewBox.baseVal.width) return clear();
  const mine = run = new AbortController();
  const progress = part('progress');
  progress.hidden = false;
  progress.value = 0;
  try {
    const question = { city: cityQuestion(), tx: state.tx, ...settingsQuestion(), show: state.show === 'error' ? 'error' : 'link', cell_m: cell() };
    const response = await ask('/api/coverage', question, mine.signal);
    for await (const line of lines(response.body)) {
      if (run !== mine) return;
      if (line.error) throw new Fault(line.error);
      if (line.of) begin(line);
      else {
        fill(line, kind);
        paint(kind);
        progress.value = line.done / grid.of;
      }
    }
    if (run === mine && progress.value < 1) throw new Error('the last cells are missing');
    if (run === mine) stop();
  } catch (fault) {
    if (fault.name === 'AbortError' || run !== mine) return;
    clear();
    if (fault.kind !== 'overtaken') fail(fault instanceof Fault ? fault : new Fault({ kind: 'gone', message: 'the coverage broke off' }));
  }
}

let side = 256;
/** Takes the size of the map. */
export function measure([min, max]) {
  side = Math.max(max[0] - min[0], max[1] - min[1]);
}
const cell = () => side / CELLS;

/** Lines of JSON of a body. */
async function* lines(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = '';
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const parts = (rest + value).split('\n');
    rest = parts.pop();
    for (const text of parts) yield JSON.parse(text);
  }
}

function begin(head) {
  grid = head;
  values = new Float32Array(grid.of).fill(NaN);
  [canvas.width, canvas.height] = [grid.columns, grid.rows];
  part('map').classList.add('is-covered');
}

/** A value stands for all cells up to the next of its pass, until these come. */
function fill(block, kind) {
  const scale = kind.scale ?? (v => v);
  block.at.forEach((at, n) => {
    const value = block[kind.of][n];
    const [i0, j0] = [at % grid.columns, Math.floor(at / grid.columns)];
    const [i1, j1] = [Math.min(i0 + block.stride, grid.columns), Math.min(j0 + block.stride, grid.rows)];
    for (let j = j0; j < j1; j++) values.fill(value === null ? NaN : scale(value), j * grid.columns + i0, j * grid.columns + i1);
  });
}

/** Paints the same values in the colours of another theme. */
export const repaint = () => { if (values) paint(KINDS[state.show]); };

function paint(kind) {
  const known = values.filter(v => !Number.isNaN(v));
  if (!known.length) return;
  const high = known.reduce((a, b) => Math.max(a, b));
  const range = kind.range ?? [Math.max(known.reduce((a, b) => Math.min(a, b)), high - (kind.span ?? Infinity)), high];
  const steps = strengths();
  const colour = part => (kind.isRound ? around(part) : between(steps, part));
  const image = new ImageData(grid.columns, grid.rows);
  values.forEach((value, at) => {
    if (Number.isNaN(value)) return;
    const [i, j] = [at % grid.columns, grid.rows - 1 - Math.floor(at / grid.columns)];
    image.data.set([...colour((value - range[0]) / (range[1] - range[0] || 1)), 255], 4 * (j * grid.columns + i));
  });
  canvas.getContext('2d').putImageData(image, 0, 0);
  legend(kind.ends(range), colour);
}

function legend([low, high], colour) {
  const scale = part('scale');
  const draw = scale.getContext('2d');
  for (let x = 0; x < scale.width; x++) {
    draw.fillStyle = `rgb(${colour(x / (scale.width - 1)).map(Math.round)})`;
    draw.fillRect(x, 0, 1, scale.height);
  }
  part('low').textContent = low;
  part('high').textContent = high;
  part('legend').hidden = false;
}
