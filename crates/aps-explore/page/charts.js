// The spectra, drawn anew for each answer.

const RANGE_DB = 45;
const ROOM_DB = 8;

const px = value => Math.round(value * 10) / 10;

/** Text for SVG. Everything else in these pictures is a number or a name of a colour. */
const plain = text => String(text).replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);

function text(x, y, words, anchor = 'middle', extra = '') {
  return `<text x="${px(x)}" y="${px(y)}" text-anchor="${anchor}" class="small halo" ${extra}>${plain(words)}</text>`;
}

function badge([x, y], lobe) {
  const words = plain(lobe.cells[0]);
  const isImage = lobe.side !== 'own';
  const look = isImage && lobe.path !== null
    ? `class="paper stroke-${lobe.colour}" stroke-width="2"` : `class="fill-${lobe.colour}"`;
  return `<g ${lobe.path === null ? '' : `data-path="${lobe.path}"`} class="${isImage ? 'hollow' : ''}">`
    + `<circle cx="${px(x)}" cy="${px(y)}" r="8.5" ${look}/>`
    + `<text class="number" x="${px(x)}" y="${px(y + 4)}" text-anchor="middle">${words}</text></g>`;
}

/** Top of the axis of power: steps of 10 dB, so that it stands still while a terminal moves. */
const topOf = curve => Math.ceil((Math.max(...curve.aps_db) + 1) / 10) * 10;

const line = (points, look) => `<polyline class="line ${look}" points="${points.map(p => p.map(px).join()).join(' ')}"/>`;

/** A chart of power over something. */
class Frame {
  constructor(width, height, x, top) {
    Object.assign(this, { width, height, x, top, left: 44, right: width - 16, up: 12, down: height - 34 });
  }

  at(x, db) {
    const part = (Math.max(db, this.top - RANGE_DB) - this.top + RANGE_DB) / (RANGE_DB + ROOM_DB);
    const along = (x - this.x.from) / (this.x.to - this.x.from);
    return [this.left + along * (this.right - this.left), this.down - part * (this.down - this.up)];
  }

  axes() {
    let out = '';
    for (let db = this.top; db >= this.top - RANGE_DB; db -= 10) {
      const [, y] = this.at(this.x.from, db);
      out += `<path class="grid" d="M${this.left} ${px(y)}H${this.right}"/>${text(this.left - 5, y + 4, db, 'end')}`;
    }
    for (let x = this.x.from; x <= this.x.to; x += this.x.step) {
      const [place] = this.at(x, this.top);
      out += `<path class="grid" d="M${px(place)} ${this.up}V${this.down}"/>${text(place, this.down + 15, x)}`;
    }
    return out + `<rect class="frame" x="${this.left}" y="${this.up}" width="${this.right - this.left}" height="${this.down - this.up}"/>`
      + text((this.left + this.right) / 2, this.height - 4, this.x.name)
      + text(this.left + 4, this.up + 12, 'power over power sent [dB]', 'start');
  }
}

/** Fills a picture: its axes, whose text is dear, only when they change, and what is drawn over them. */
function put(svg, ...parts) {
  parts.forEach((content, i) => {
    const group = svg.children[i] ?? svg.appendChild(document.createElementNS(svg.namespaceURI, 'g'));
    if (group.content === content) return;
    group.innerHTML = content;
    group.content = content;
  });
}

/** Curves of an answer with their looks, the main one last. */
function curves(answer, { other, reference, model }) {
  const list = [];
  if (other && answer.other) list.push([answer.other, 'thin dashed stroke-soft']);
  if (reference) list.push([reference, 'thin stroke-s2']);
  if (model && answer.model?.curve) list.push([answer.model.curve, 'model stroke-s3']);
  list.push([answer.spectrum, 'stroke-ink']);
  return list;
}

export function draw(answer, overlays) {
  const [polar, aps, pdp] = ['polar', 'aps', 'pdp'].map(id => document.getElementById(id));
  if (!answer.spectrum) {
    const words = answer.is_enclosed ? 'a closed building lies between the ends' : 'no path within the limits, no spectrum';
    for (const svg of [polar, aps, pdp]) {
      const { width, height } = svg.viewBox.baseVal;
      put(svg, text(width / 2, height / 2, words), '');
    }
    return;
  }
  const list = curves(answer, overlays);
  const top = topOf(answer.spectrum);
  put(aps, ...overAngle(answer, list, top));
  put(pdp, ...overDelay(answer, list));
  put(polar, ...overDirection(answer, list, top));
}

function overAngle(answer, list, top) {
  const sense = answer.spectrum.protocol === 'released' ? 'direction of travel at the receiver' : 'angle of arrival';
  const name = `${sense} [deg]${answer.turn_deg % 180 ? ', from the heading of the array' : ''}`;
  const frame = new Frame(700, 270, { from: -180, to: 180, step: 30, name }, top);
  let out = '';
  const stem = (path, angle, look) => {
    if (path.gain_db < top - RANGE_DB) return '';
    const [[x, y0], [, y1]] = [frame.at(angle, -1e9), frame.at(angle, path.gain_db)];
    return `<path class="line ${look} stroke-${path.colour}" data-path="${path.number}" d="M${px(x)} ${px(y0)}V${px(y1)}"/>`;
  };
  for (const path of answer.paths.toReversed()) {
    if (path.mirror_deg !== null && path.colour !== 'soft') out += stem(path, path.mirror_deg, 'dashed');
    out += stem(path, path.angle_deg, '');
  }
  for (const [curve, look] of list) out += line(curve.angles_deg.map((angle, i) => frame.at(angle, curve.aps_db[i])), look);
  const marks = badges(answer.lobes, (lobe, step) => {
    const [x, y] = frame.at(lobe.angle_deg, lobe.level_db + 3.5);
    return [x, y - step];
  });
  return [frame.axes(), out + marks];
}

/** Badges of lobes, those that would lie on another a step further out. */
function badges(lobes, at) {
  const taken = [];
  const isFree = ([x, y]) => taken.every(([u, v]) => Math.hypot(x - u, y - v) > 16);
  return lobes.map(lobe => {
    const places = [0, 16, 32].map(step => at(lobe, step));
    const place = places.find(isFree) ?? places[0];
    taken.push(place);
    return badge(place, lobe);
  }).join('');
}

function overDelay(answer, list) {
  const { pdp_db: levels, step_ns: step } = answer.spectrum;
  const top = topOf({ aps_db: levels });
  const frame = new Frame(380, 300, { from: 0, to: Math.round(step * (levels.length - 1)), step: 200, name: 'delay [ns]' }, top);
  let out = '';
  for (const path of answer.paths.toReversed()) {
    if (path.gain_db < top - RANGE_DB || path.delay_ns > frame.x.to) continue;
    const [[x, y0], [, y1]] = [frame.at(path.delay_ns, -1e9), frame.at(path.delay_ns, path.gain_db)];
    out += `<path class="line stroke-${path.colour}" data-path="${path.number}" d="M${px(x)} ${px(y0)}V${px(y1)}"/>`;
  }
  for (const [curve, look] of list) out += line(curve.pdp_db.map((db, i) => frame.at(i * curve.step_ns, db)), look);
  return [frame.axes(), out];
}

function overDirection(answer, list, top) {
  const [middle, radius] = [150, 118];
  const at = (angle, db, more = 0) => {
    const part = Math.max(0, (db - top + RANGE_DB) / RANGE_DB);
    const turn = (angle + answer.turn_deg) * Math.PI / 180;
    const r = part * radius + more;
    return [middle + r * Math.cos(turn), middle - r * Math.sin(turn)];
  };
  let [axes, out] = ['', ''];
  for (const db of [0, 15, 30]) {
    const r = (RANGE_DB - db) / RANGE_DB * radius;
    axes += `<circle class="grid" cx="150" cy="150" r="${r}"/>${text(middle + 3, middle - r + 12, `${top - db} dB`, 'start')}`;
  }
  for (const [words, angle] of [['0°', 0], ['90°', 90], ['180°', 180], ['−90°', 270]]) {
    const [x, y] = at(angle - answer.turn_deg, top, 13);
    axes += text(x, y + 4, words);
  }
  for (const path of answer.paths.toReversed()) {
    if (path.gain_db < top - RANGE_DB) continue;
    const [x, y] = at(path.angle_deg, path.gain_db);
    out += `<path class="line stroke-${path.colour}" data-path="${path.number}" d="M150 150L${px(x)} ${px(y)}"/>`;
  }
  for (const [curve, look] of list) {
    const points = curve.angles_deg.map((angle, i) => at(angle, curve.aps_db[i]));
    out += line([...points, points[0]], look);
  }
  return [axes, out + badges(answer.lobes, (lobe, step) => at(lobe.angle_deg, lobe.level_db, 10 + step))];
}
