// Lobes and paths as tables, the same as on the page of `explain`.

const NAMES = ['Lobes', 'Paths'];

function row(item) {
  const tr = document.createElement('tr');
  item.cells.forEach((cell, i) => {
    const td = tr.insertCell();
    if (i > 0) return void (td.textContent = cell);
    const chip = document.createElement('span');
    chip.className = `chip ${item.colour}${(item.side ?? 'own') === 'own' ? '' : ' is-image'}`;
    chip.textContent = cell;
    td.append(chip);
  });
  const number = item.number ?? item.path;
  if (number !== null) tr.dataset.path = number;
  if (item.side === 'mirror') tr.dataset.mirror = '';
  tr.tabIndex = 0;
  return tr;
}

/** Rest between two drawings while answers come thirty times a second [ms]: nobody reads faster. */
const REST = 100;
let last = -Infinity;
let waiting = null;

/** Draws both tables, at once or a little later with what came last. Whoever stands in a row stays there. */
export function show(answer) {
  clearTimeout(waiting);
  const rest = last + REST - performance.now();
  if (rest > 0) waiting = setTimeout(() => draw(answer), rest);
  else draw(answer);
}

function draw(answer) {
  last = performance.now();
  const section = document.getElementById('tables');
  const focused = [...section.querySelectorAll('tbody tr')].indexOf(document.activeElement);
  section.replaceChildren(...[answer.lobes, answer.paths].map((items, i) => {
    const box = document.createElement('div');
    box.className = 'scroll';
    const table = document.createElement('table');
    table.createCaption().textContent = `${NAMES[i]}: ${items.length}`;
    const head = table.createTHead().insertRow();
    for (const name of answer.columns[i]) head.append(Object.assign(document.createElement('th'), { textContent: name }));
    table.createTBody().append(...items.map(row));
    box.append(table);
    return box;
  }));
  if (focused >= 0) section.querySelectorAll('tbody tr')[focused]?.focus({ preventScroll: true });
}

const sheet = new CSSStyleSheet();
document.adoptedStyleSheets = [sheet];

/** Makes everything on the page that belongs to a path stand out: by rules, so that it stays when pictures are drawn anew. */
function light(number) {
  sheet.replaceSync(number === null ? '' :
    `svg [data-path]:not([data-path="${number}"]){opacity:.12} tr[data-path="${number}"]{background:var(--panel)}`);
}

/** Lights up what is pointed at, focused or touched; `mark` is told the path's number. */
export function watch(mark) {
  const choose = event => {
    const number = event.target.closest?.('[data-path]')?.dataset.path ?? null;
    light(number);
    mark(number === null ? null : Number(number));
  };
  for (const kind of ['pointerover', 'focusin', 'pointerdown']) document.addEventListener(kind, choose);
  document.addEventListener('pointerleave', () => { light(null); mark(null); });
}
