// Sliders and switches, and what each change did to error and time.

import { state } from './state.js';

const MOST_EFFECTS = 4;

/** The controls in their order. */
const CONTROLS = [
  { key: 'reflections', name: 'Reflections', min: 0, max: 6 },
  { key: 'diffractions', name: 'Diffractions', min: 0, max: 3 },
  { key: 'slopes', name: 'Slope diffraction', words: { off: 'off', on: 'on' } },
  { key: 'range', name: 'Dynamic range', min: 10, max: 130, step: 10, unit: ' dB', most: 'all paths' },
  { key: 'frequency', name: 'Carrier', min: 0.3, max: 60, step: 0.1, unit: ' GHz', factor: 1e9 },
  { key: 'material', name: 'Walls', words: { concrete: 'concrete', pec: 'perfect conductor', '2.73,0.0085': 'plasterboard', '6.31,0.0162': 'glass', '3.91,0.0238': 'brick' } },
  { key: 'protocol', name: 'Protocol', words: { paper: 'paper', released: 'released' } },
  { key: 'array', name: 'Array', words: { ula: 'linear', uca: 'circular' } },
  { key: 'elements', name: 'Elements', min: 1, max: 64 },
  { key: 'spacing', name: 'Spacing', min: 0.1, max: 2, step: 0.05, unit: ' λ' },
  { key: 'heading', name: 'Heading', min: -180, max: 180, step: 5, unit: '°' },
  { key: 'bandwidth', name: 'Bandwidth', min: 10, max: 1000, step: 10, unit: ' MHz', factor: 1e6 },
];

/** A value in words. */
function told(control, value) {
  if (control.words) return control.words[value] ?? value;
  if (value === null) return control.most;
  const number = +(value / (control.factor ?? 1)).toPrecision(6);
  return `${number}${control.unit ?? ''}`;
}

/** Puts the controls on the page; `changed` is called with the change in words. */
export function makeControls(changed) {
  const form = document.getElementById('controls');
  form.addEventListener('submit', event => event.preventDefault());
  for (const control of CONTROLS) {
    const label = document.createElement('label');
    const head = document.createElement('span');
    const value = document.createElement('b');
    let input;
    if (control.words) {
      input = document.createElement('select');
      for (const [word, name] of Object.entries(control.words)) input.add(new Option(name, word));
      head.append(control.name);
    } else {
      input = Object.assign(document.createElement('input'), { type: 'range', min: control.min, max: control.max, step: control.step ?? 1 });
      head.append(`${control.name} `, value);
    }
    input.id = `set-${control.key}`;
    label.append(head, input);
    form.append(label);
    Object.assign(control, { input, value });
    input.addEventListener('input', () => {
      const before = told(control, state[control.key]);
      state[control.key] = read(control);
      show(control);
      const after = told(control, state[control.key]);
      if (before !== after) changed({ key: control.key, name: control.name, before, after });
    });
  }
}

function read({ input, words, max, factor = 1, most }) {
  if (words) return input.value;
  const number = Number(input.value);
  if (most && number >= max) return null;
  // Two products of decimal numbers can differ in the last digit; the address shall not show it.
  return +(number * factor).toPrecision(12);
}

function show(control) {
  const value = state[control.key];
  if (control.words) {
    const isKnown = [...control.input.options].some(option => option.value === value);
    if (!isKnown) control.input.add(new Option(value, value));
    control.input.value = value;
  } else {
    control.input.value = value === null ? control.max : value / (control.factor ?? 1);
    control.value.textContent = told(control, value);
    control.input.setAttribute('aria-valuetext', told(control, value));
  }
}

/** Shows the state. */
export const showControls = () => CONTROLS.forEach(show);

export const us = value => (value < 1000 ? `${value.toFixed(0)} µs` : value < 1e6 ? `${(value / 1000).toFixed(1)} ms` : `${(value / 1e6).toFixed(2)} s`);
const perLink = ({ rx, join, label }) => rx + join + label;
const error = compared => (compared.error_db ? `${compared.error_db.mean.toFixed(2)} dB (worst ${compared.error_db.worst.toFixed(1)})` : 'none: no path there');

/** In words: the error and times of a link now. */
export function toldNow(compared) {
  const { times_us: own, paths } = compared.own;
  const best = compared.reference;
  return `Now: error ${error(compared)} against the reference limits; a link ${us(perLink(own))}, transmitter ${us(own.tx)}, map ${us(own.map)}, `
    + `${paths} paths. Reference: ${us(perLink(best.times_us))}, ${us(best.times_us.tx)}, ${us(best.times_us.map)}, ${best.paths} paths.`;
}

let notes = [];

/** Puts the effect of changes first in the list. */
export function tellEffect(changes, before, after) {
  const pair = (of, words) => `${words(of(before))} → ${words(of(after))}`;
  const times = compared => compared.own.times_us;
  const what = changes.map(change => `${change.name} ${change.before} → ${change.after}`).join(', ');
  const text = `${what}: error ${pair(c => c, error)}; link ${pair(c => perLink(times(c)), us)}, `
    + `transmitter ${pair(c => times(c).tx, us)}, map ${pair(c => times(c).map, us)}; paths ${pair(c => c.own.paths, String)}`;
  notes = [text, ...notes].slice(0, MOST_EFFECTS);
}

export function showEffects(now) {
  const list = document.querySelector('#effects ol');
  list.replaceChildren(...[now, ...notes].map(text => Object.assign(document.createElement('li'), { textContent: text })));
}
