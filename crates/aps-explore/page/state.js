// Everything that is chosen, and its form in the address of the page.

import defaults from './defaults.js';

/** Limits and label of the command line's defaults, quick enough to follow a dragged terminal on any map, and the curves that are drawn. */
export const DEFAULTS = { ...defaults, other: 'on', reference: 'off', model: 'off' };

export const state = { ...DEFAULTS, map: null, tx: null, rx: null, show: '', houses: none() };

/** No change of any house. */
export function none() {
  return { moved: [], gone: [], drawn: [] };
}

export function isChanged(houses) {
  return houses.moved.length + houses.gone.length + houses.drawn.length > 0;
}

const WORDS = ['material', 'protocol', 'array', 'show'];
const SWITCHES = ['slopes', 'other', 'reference', 'model'];

/** The fragment of the address: whatever differs from the defaults. */
export function toFragment() {
  const parts = new URLSearchParams();
  const put = (name, value) => parts.set(name, value);
  if (state.map !== null) put('map', state.map);
  for (const end of ['tx', 'rx']) if (state[end]) put(end, state[end].join(','));
  for (const [name, value] of Object.entries(DEFAULTS)) {
    if (state[name] !== value) put(name, state[name] ?? 'all');
  }
  if (state.show) put('show', state.show);
  if (isChanged(state.houses)) put('houses', JSON.stringify(state.houses));
  return '#' + parts.toString().replaceAll('%2C', ',');
}

/** Takes the fragment over; what cannot be read is left out, and what is out of range the server refuses. */
export function fromFragment(fragment) {
  const parts = new URLSearchParams(fragment.replace(/^#/, ''));
  Object.assign(state, DEFAULTS, { map: null, tx: null, rx: null, show: '', houses: none() });
  const number = text => (text === null || text.trim() === '' || !Number.isFinite(Number(text)) ? null : Number(text));
  state.map = number(parts.get('map'));
  for (const end of ['tx', 'rx']) {
    const pair = (parts.get(end) ?? '').split(',').map(number);
    if (pair.length === 2 && !pair.includes(null)) state[end] = pair;
  }
  for (const name of Object.keys(DEFAULTS)) {
    const text = parts.get(name);
    if (text === null || WORDS.includes(name)) continue;
    if (SWITCHES.includes(name)) { if (['on', 'off'].includes(text)) state[name] = text; continue; }
    if (name === 'range' && text === 'all') state.range = null;
    else state[name] = number(text) ?? DEFAULTS[name];
  }
  for (const name of WORDS) if (parts.has(name)) state[name] = parts.get(name);
  try {
    const houses = JSON.parse(parts.get('houses') ?? 'null');
    if (houses && ['moved', 'gone', 'drawn'].every(name => Array.isArray(houses[name]))) state.houses = houses;
  } catch { /* a cut address: the houses as they were read */ }
}

/** Parts of the server's questions. */
export const cityQuestion = () => ({ map: state.map, houses: state.houses });

export const settingsQuestion = () => ({
  trace: {
    reflections: state.reflections, diffractions: state.diffractions, slope_diffraction: state.slopes === 'on', dynamic_range_db: state.range,
    frequency_hz: state.frequency, material: state.material,
  },
  label: {
    protocol: state.protocol, array: state.array, elements: state.elements, spacing: state.spacing,
    heading_deg: state.heading, sampling_rate_hz: state.bandwidth,
  },
});

export const linkQuestion = () => ({ city: cityQuestion(), tx: state.tx, rx: state.rx, ...settingsQuestion(), model: state.model === 'on' });
