// The page: what is asked when, and what is drawn of the answers.

import { ask, Lane } from './ask.js';
import * as charts from './charts.js';
import * as city from './city.js';
import * as coverage from './coverage.js';
import * as houses from './houses.js';
import * as settings from './settings.js';
import * as tables from './tables.js';
import { cityQuestion, fromFragment, linkQuestion, none, state, toFragment } from './state.js';

const part = id => document.getElementById(id);

/** Rest after the last change before anything slow is asked [ms]. */
const PAUSE = 250;

/** Curves that may be drawn over the spectrum. */
const OVERLAYS = ['other', 'reference', 'model'];

let maps = { source: '', ids: [] };
let answer = null;
let reference = null;
/** The question before the changes whose effect is not told yet, its comparison if there is one, and these. */
let settled = null;
let before = null;
let changes = [];
/** The reason why the map is not the one that the address names. */
let missing = '';
let timer = null;
let isCoverageDue = false;
/** Answers drawn, for whoever measures. */
window.explorer = { drawn: 0, compared: 0 };

function fail(fault) {
  part('fault').textContent = fault.message;
  part('fault').hidden = false;
}

const failed = fault => { fail(fault); document.body.classList.add('is-stale'); };

const link = new Lane('/api/link', (got) => {
  answer = got;
  part('fault').hidden = true;
  document.body.classList.remove('is-stale');
  city.drawLink(answer);
  redraw();
  tables.show(answer);
  summary();
  window.explorer.drawn += 1;
}, failed);

const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const ends = question => [question.city.map, question.tx, question.rx];

/** Tells if two questions have the same comparison. */
const isCompared = (a, b) => isSame({ ...a, model: null }, { ...b, model: null });

/** The question before the changes, of the link of now; none if its comparison is there, or nothing is changed. */
function earlier() {
  const now = linkQuestion();
  if (!changes.length || !settled || (before && isSame(ends(before.asked), ends(now)))) return null;
  return { ...settled, tx: now.tx, rx: now.rx };
}

const comparison = new Lane('/api/compare', (got, asked) => {
  if (isCompared(asked, earlier())) {
    before = { got, asked };
    comparison.ask(linkQuestion());
    return;
  }
  // Of a link or limits of the past: the question of the present follows.
  if (!isCompared(asked, linkQuestion())) return;
  window.explorer.compared += 1;
  reference = got.curve;
  if (changes.length && before && isSame(ends(before.asked), ends(asked))) settings.tellEffect(changes, before.got, got);
  changes = [];
  [settled, before] = [asked, { got, asked }];
  settings.showEffects(settings.toldNow(got));
  if (state.reference === 'on' && answer) redraw();
}, (fault, asked) => {
  // Before the changes there was no such link: there is nothing to hold them against.
  if (!isCompared(asked, earlier())) return fail(fault);
  settled = null;
  comparison.ask(linkQuestion());
});

/** Keeps a change until its effect is known; several of one control are one. */
function note(change) {
  const known = changes.find(one => one.key === change.key);
  changes = [...changes.filter(one => one !== known), known ? { ...change, before: known.before } : change]
    .filter(one => one.before !== one.after);
}

const cityLane = new Lane('/api/map', (got, asked) => {
  if (asked.map !== state.map) return;
  part('fault').hidden = true;
  city.drawCity(got);
  coverage.measure(got.area);
  houses.drawHouses(got);
  const changed = got.repairs === got.repairs_as_read ? '' : ` (as read: ${got.repairs_as_read})`;
  const own = got.houses.filter(h => h.repairs && (h.id >= got.as_read || asked.houses.moved.some(m => m[0] === h.id)));
  part('repairs').textContent = `${missing}${got.walls} walls; repairs of the houses: ${got.repairs}${changed}`
    + own.map(h => `; house ${h.id}: ${h.repairs}`).join('');
  state.tx ??= got.tx;
  state.rx ??= got.rx;
  city.drawTerminals();
  changedPlace();
}, fault => {
  // Houses that make no scene: as they were before, with the reason.
  if (fault.kind !== 'gone' && fault.kind !== 'broken' && houses.undo()) setTimeout(() => fail(fault), PAUSE);
  else fail(fault);
});

function redraw() {
  const isOn = name => state[name] === 'on';
  charts.draw(answer, { other: isOn('other'), reference: isOn('reference') ? reference : null, model: isOn('model') });
  part('told-model').textContent = isOn('model') ? toldModel(answer.model) : '';
}

/** The scores of the prediction in words, or the reason why there is none. */
function toldModel(model) {
  if (!model) return answer.spectrum ? 'the map is prepared for the model ...' : 'no label to hold a prediction against';
  if (model.reason) return `no prediction: ${model.reason}`;
  const [link, map] = model.times_us.map(settings.us);
  return `CosSim ${model.cosine.toFixed(3)}, MAE ${model.mae.toFixed(3)} against the label; link ${link}, map ${map}`
    + (model.is_foreign ? '; the label is of other limits or walls than it learnt' : '');
}

function summary() {
  const db = answer.path_loss_db === null ? 'no path' : `path loss ${answer.path_loss_db.toFixed(1)} dB, delay spread ${answer.delay_spread_ns.toFixed(0)} ns`;
  part('summary').textContent = `${answer.distance_m.toFixed(0)} m, ${answer.line_of_sight ? 'line of sight' : 'no line of sight'}, `
    + `${answer.link.paths.length} paths, ${db}`;
  part('other-name').textContent = `protocol ${answer.other?.protocol ?? (state.protocol === 'paper' ? 'released' : 'paper')}`;
}

/** Something of the link has changed: ask at once, and for the slow things when nothing changes any more. */
function changedPlace(isOver = true, needsCoverage = true) {
  if (!state.tx || !state.rx) return;
  link.ask(linkQuestion());
  if (!changes.length) settled = linkQuestion();
  reference = null;
  isCoverageDue ||= needsCoverage || coverage.isRunning();
  if (isCoverageDue) coverage.stop();
  clearTimeout(timer);
  timer = setTimeout(() => {
    history.replaceState(null, '', toFragment());
    if (!isOver) return;
    comparison.ask(earlier() ?? linkQuestion());
    if (isCoverageDue) coverage.start(fail);
    isCoverageDue = false;
  }, PAUSE);
}

function changedCity() {
  city.clearLink();
  city.drawTerminals();
  coverage.clear();
  settings.showEffects('The reference limits, 5 reflections and 2 diffractions within 30 dB, are prepared for this map ...');
  cityLane.ask(cityQuestion());
}

/** Forgets what belongs to the map before. */
function leaveCity() {
  [settled, before, changes] = [null, null, []];
  houses.forget();
  changedCity();
}

function takeFile(name) {
  const names = { map: `map-${state.map}.json`, paths: 'link.json', picture: 'link.svg', explanation: 'link.html' };
  return async () => {
    try {
      const file = await (await ask(`/api/file/${name}`, linkQuestion())).blob();
      if (name === 'command') {
        part('command').textContent = await file.text();
        part('command').hidden = false;
        return;
      }
      const address = URL.createObjectURL(file);
      Object.assign(document.createElement('a'), { href: address, download: names[name] }).click();
      setTimeout(() => URL.revokeObjectURL(address), 10_000);
    } catch (fault) {
      fail(fault);
    }
  };
}

/** Shows the state that the address holds. */
function takeAddress() {
  fromFragment(location.hash);
  missing = '';
  if (!maps.ids.includes(state.map)) {
    if (state.map !== null) missing = `there is no map ${state.map} among those of ${maps.source}, this is map ${maps.ids[0]}; `;
    Object.assign(state, { map: maps.ids[0], tx: null, rx: null });
  }
  part('maps').value = state.map;
  part('show').value = state.show;
  state.show = part('show').value;
  for (const name of OVERLAYS) part(`with-${name}`).checked = state[name] === 'on';
  settings.showControls();
  leaveCity();
}

async function begin() {
  maps = await (await ask('/api/maps')).json();
  part('maps').append(...maps.ids.map(id => new Option(`${id}`, id)));
  part('maps').title = maps.source;
  settings.makeControls(change => {
    note(change);
    changedPlace();
  });
  city.watchTerminals({
    // A receiver that moves leaves finished coverage as it is.
    moved: (end, isOver) => changedPlace(isOver, end === 'tx'),
    isActive: () => !houses.isDrawing(),
    snap: coverage.snap,
  });
  houses.watchHouses(() => {
    note({ key: 'houses', name: 'Houses', before: 'before', after: 'now' });
    changedCity();
  });
  tables.watch(city.markTwin);
  for (const name of OVERLAYS) {
    part(`with-${name}`).addEventListener('change', event => {
      state[name] = event.target.checked ? 'on' : 'off';
      history.replaceState(null, '', toFragment());
      if (name === 'model') link.ask(linkQuestion());
      if (answer) redraw();
    });
  }
  for (const button of document.querySelectorAll('[data-file]')) button.addEventListener('click', takeFile(button.dataset.file));
  part('maps').addEventListener('change', event => {
    Object.assign(state, { map: Number(event.target.value), tx: null, rx: null, houses: none() });
    missing = '';
    leaveCity();
  });
  part('show').addEventListener('change', event => {
    state.show = event.target.value;
    history.replaceState(null, '', toFragment());
    coverage.start(fail);
  });
  addEventListener('hashchange', takeAddress);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', coverage.repaint);
  takeAddress();
}

begin().catch(fail);
