// The live page: shows the newest frame and what the run says of itself. Everything is asked for anew, one
// request of a kind at a time: a slow network shows fewer frames, never older ones.
'use strict';

const $ = (id) => document.getElementById(id);
const picture = $('picture');
const state = { frame: null, scale: null, pointer: null, shown: null };

const wait = (ms) => new Promise((done) => setTimeout(done, ms));

function say(text, bad) {
  $('state').textContent = text;
  $('state').classList.toggle('bad', Boolean(bad));
}

// --- the picture

// Where display and browser can, the picture keeps its light; false colours and provenance have none.
const hdr_display = matchMedia('(dynamic-range: high)');

function picture_url() {
  const look = $('look').value, keeps_light = hdr_display.matches && look === 'tone';
  const query = new URLSearchParams(keeps_light ? { ev: $('ev').value } : { ev: $('ev').value, look });
  const wish = query.toString();
  if (state.shown && state.shown.wish === wish) query.set('after', state.shown.sequence);
  return { url: (keeps_light ? 'frame.png?' : 'frame.jpg?') + query, wish, keeps_light };
}

async function draw(bytes) {
  const bitmap = await createImageBitmap(bytes);
  if (picture.width !== bitmap.width || picture.height !== bitmap.height) {
    picture.width = bitmap.width;
    picture.height = bitmap.height;
  }
  picture.getContext('2d').drawImage(bitmap, 0, 0);
  bitmap.close();
}

// A canvas has the range of SDR; an image has that of the display. The new one takes the place of the old when it
// has been decoded, so that nothing flickers.
async function show_light(bytes) {
  const next = $('light').cloneNode();
  next.src = URL.createObjectURL(bytes);
  try {
    await next.decode();
    $('light').replaceWith(next);
  } finally {
    URL.revokeObjectURL(next.src);
  }
}

async function show_picture() {
  const { url, wish, keeps_light } = picture_url();
  const answer = await fetch(url);
  if (answer.status === 204) return wait(20);
  if (!answer.ok) return wait(300);
  const bytes = await answer.blob();
  await (keeps_light ? show_light(bytes) : draw(bytes));
  picture.hidden = keeps_light;
  $('light').hidden = !keeps_light;
  state.shown = { sequence: answer.headers.get('X-Sequence'), wish };
  picture.dataset.sequence = state.shown.sequence;
}

// --- the radiance under the pointer

async function show_pixel() {
  const at = state.pointer;
  if (!at || !state.frame) return wait(60);
  const x = Math.min(state.frame.width - 1, Math.floor(at.x * state.frame.width));
  const y = Math.min(state.frame.height - 1, Math.floor(at.y * state.frame.height));
  const answer = await fetch(`pixel?x=${x}&y=${y}`);
  if (!answer.ok) return wait(300);
  const pixel = await answer.json();
  const cursor = $('cursor');
  cursor.textContent = `${rounded(pixel.stops, 2)} stops at ${x}, ${y}:  R ${pixel.radiance[0].toPrecision(4)}  ` +
    `G ${pixel.radiance[1].toPrecision(4)}  B ${pixel.radiance[2].toPrecision(4)}  ±${(pixel.sigma / Math.LN2).toFixed(2)} ` +
    `stops, ${pixel.provenance}`;
  Object.assign(cursor.dataset, { sequence: pixel.sequence, x, y, radiance: JSON.stringify(pixel.radiance) });
  return wait(60);
}

$('screen').addEventListener('pointermove', (event) => {
  const box = $('screen').getBoundingClientRect();
  state.pointer = { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
});
$('screen').addEventListener('pointerleave', () => { state.pointer = null; });

// --- the figures

function fill(table, rows) {
  $(table).replaceChildren(...rows.map(([name, value, colour]) => {
    const row = document.createElement('tr');
    const cells = [name, value].map((text) => {
      const cell = document.createElement('td');
      cell.textContent = text;
      row.append(cell);
      return cell;
    });
    if (colour) cells[0].prepend(swatch(colour));
    return row;
  }));
}

function swatch(colour) {
  const box = document.createElement('span');
  box.className = 'swatch';
  box.style.background = colour;
  return box;
}

const percent = (share) => (share < 1 ? Math.min(100 * share, 99.9) : 100).toFixed(1) + ' %';  // 100.0 only for all
// Zero without a sign, which what was rounded to it may have.
const rounded = (value, decimals) => value.toFixed(decimals).replace(/^-(?=[0.]*$)/, '');
const ms = (time) => time.toFixed(1) + ' ms';
const seconds_as_text = (s) => s >= 0.1 ? s.toPrecision(3) + ' s' : +(1e3 * s).toPrecision(3) + ' ms';

function show_figures(status) {
  const counters = status.counters;
  const has_camera = 'captured' in counters;
  const rows = [['emitted', has_camera ? counters.emitted : status.frames],
    ['per second', status.frames_per_second.toFixed(1)]];
  if (has_camera) {
    rows.unshift(['captured', counters.captured]);
    rows.push(['latency', ms(status.latency_ms)], ['recorded', counters.recorded], ['lost by the camera', counters['camera.lost']]);
  }
  fill('frames', rows);
  const verdict = (name) => has_camera ? counters['camera.' + name] : status.verdicts[name];
  fill('verdicts', Object.keys(status.verdicts).map((name) => [name, verdict(name)])
    .concat(status.exposures.map((e) => [`exposure ${seconds_as_text(e.time_s)}` + (e.gain === 1 ? '' : ` × ${e.gain}`),
      `saturates at ${rounded(e.saturates_at_stops, 1)} stops`])));
  const drops = Object.entries(counters).filter(([name]) => name.startsWith('dropped.'));
  fill('drops', drops.length ? drops.map(([name, count]) => [name.slice(8).replace('_', ' '), count]) : [['a replay drops nothing', '']]);
  if (!status.frame) return;
  fill('stages', Object.entries(status.mean_stages_ms).map(([name, time]) => [name, ms(time)])
    .concat([['newest frame, in all', ms(status.frame.total_ms)]]));
  const looks = state.scale.provenance;
  fill('provenance', looks.map((look) => [look.name, percent(status.frame.provenance[look.key]), look.colour]));
  draw_histogram(status);
}

function draw_histogram(status) {
  const canvas = $('histogram'), pen = canvas.getContext('2d');
  const [least, most] = status.stops, bins = status.frame.histogram;
  const rise = 14 * status.exposures.length + 8, foot = canvas.height - 18;
  const x_of = (stops) => (Math.min(most, Math.max(least, stops)) - least) / (most - least) * canvas.width;
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.font = '11px system-ui, sans-serif';
  const top = Math.sqrt(Math.max(...bins, 1)), colours = state.scale.false_colours;
  bins.forEach((count, i) => {  // heights are square roots, so that small lights are seen
    const height = Math.sqrt(count) / top * (foot - rise);
    pen.fillStyle = colours[Math.round((i + 0.5) / bins.length * (colours.length - 1))];
    pen.fillRect(i / bins.length * canvas.width, foot - height, canvas.width / bins.length - 1, height);
  });
  pen.fillStyle = '#9a9a9a';
  for (let stop = Math.ceil(least); stop <= most; stop += 2) pen.fillText(String(stop), x_of(stop) - 4, canvas.height - 4);
  const range_stops = 8;
  status.exposures.forEach((exposure, i) => {
    const right = x_of(exposure.saturates_at_stops), left = x_of(exposure.saturates_at_stops - range_stops);
    const y = 4 + 14 * i;
    pen.fillStyle = '#56b4e9';
    pen.fillRect(left, y, right - left, 3);
    pen.fillRect(right - 1, y, 2, foot - y);
    pen.fillText(seconds_as_text(exposure.time_s) + (exposure.gain === 1 ? '' : ` × ${exposure.gain}`), right + 4, y + 8);
  });
}

async function show_status() {
  if (!state.scale) {
    state.scale = await (await fetch('scale.json')).json();
    show_legend();
  }
  const status = await (await fetch('status.json')).json();
  state.frame = status.frame;
  show_figures(status);
  show_actions(status);
  say(status.frame ? `frame ${status.frame.sequence}, ${status.frame.width} × ${status.frame.height}` : 'waiting for the first frame');
  return wait(500);
}

// --- actions, with the token that the program got or printed at its start

function show_actions(status) {
  $('actions').hidden = !('captured' in status.counters);
  state.recording = status.recording;
  $('record').textContent = status.recording ? 'Stop recording' : 'Start recording';
  $('recording').textContent = status.recording;
}

async function act(path, wish) {
  const answer = await fetch(path, {
    method: 'POST',
    headers: { Authorization: 'Bearer ' + $('token').value.trim() },
    body: JSON.stringify(wish),
  }).then(async (reply) => reply.ok ? '' : (await reply.json()).error).catch(() => 'the run does not answer');
  $('answer').textContent = answer;
}

$('record').addEventListener('click', () => act('record', { on: !state.recording }));
$('actions').addEventListener('submit', (event) => {
  event.preventDefault();
  act('cycle', { shutter: $('shutter').value });
});

// A % that is no escape, in a token that a person chose, stands for itself.
function unescaped(text) {
  try {
    return decodeURIComponent(text);
  } catch (error) {
    return text;
  }
}

// The printed address carries the token; it does not stay in the address bar.
if (location.hash.startsWith('#token=')) {
  $('token').value = unescaped(location.hash.slice('#token='.length));
  history.replaceState(null, '', location.pathname);
}

// --- the controls

function show_legend() {
  const legend = $('legend');
  legend.hidden = $('look').value !== 'provenance';
  if (state.scale)
    legend.replaceChildren(...state.scale.provenance.map((look) => {
      const item = document.createElement('li');
      item.append(swatch(look.colour), look.name);
      return item;
    }));
}
$('look').addEventListener('change', show_legend);
$('ev').addEventListener('input', () => {
  const ev = Number($('ev').value);
  $('ev_value').textContent = `${ev > 0 ? '+' : ''}${ev} stops`;
});
$('ev').addEventListener('dblclick', () => {
  $('ev').value = 0;
  $('ev').dispatchEvent(new Event('input'));
});

// Repeats for ever; where the run is gone it tries again.
async function keep(doing) {
  for (;;) {
    try {
      if (document.hidden) await wait(200);
      else await doing();
    } catch (error) {
      say('the run does not answer', true);
      await wait(1000);
    }
  }
}

keep(show_status);
keep(show_picture);
keep(show_pixel);
