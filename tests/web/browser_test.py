#!/usr/bin/env python3
"""The live view in a real browser: browser_test.py HDRCAM [SCREENSHOT.jpg]. Starts `hdrcam live` on the simulator and
Debian's Chromium without a screen, and ends with an error at the first thing that is not as docs/live-view.md says."""
import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from browser import Browser
from crowd import DAWDLING, LOOKING, Crowd
from exr_reader import read_pixel
from program import TOKEN, Program

def step(text):
    print(f'  {text}', flush=True)


def check_moving_picture(browser):
    browser.wait_for('return document.getElementById("picture").dataset.sequence', 'a picture')
    look = '''const canvas = document.getElementById('picture');
              const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
              return {sequence: Number(canvas.dataset.sequence), width: canvas.width, height: canvas.height,
                      pixels: Array.from(pixels.filter((_, i) => i % 4 === 1 && i % 68 === 1))};'''
    seen = []
    end = time.monotonic() + 60
    while len(seen) < 10 and time.monotonic() < end:
        picture = browser.run(look)
        if not seen or picture['sequence'] != seen[-1]['sequence']:
            seen.append(picture)
    assert len(seen) == 10, f'only {len(seen)} pictures in a minute'
    sequences = [picture['sequence'] for picture in seen]
    assert sequences == sorted(sequences), f'older pictures after newer ones: {sequences}'
    first, last = seen[0]['pixels'], seen[-1]['pixels']
    changed = sum(abs(a - b) > 8 for a, b in zip(first, last)) / len(first)
    assert changed > 0.02, f'only {100 * changed:.1f} % of the pixels changed over {sequences}'
    assert max(first) - min(first) > 100, 'the picture is flat'
    step(f'the picture moves: frames {sequences[0]} to {sequences[-1]}, {100 * changed:.0f} % of the pixels changed')


def check_radiance_under_pointer(browser, program):
    compared = set()
    for dx, dy in ((0, 0), (-120, -90), (150, 60)):
        browser.point_at('#picture', dx, dy)
        for _ in range(200):
            shown = browser.wait_for('const d = document.getElementById("cursor").dataset;'
                                     f'return d.sequence && !{json.dumps([x for x, _ in compared])}.includes(d.x)'
                                     ' ? {...d} : null', 'a figure under the pointer')
            headers, file = program.get('frame.exr')
            if headers['X-Sequence'] == shown['sequence']:
                break
        else:
            raise AssertionError('no file of the frame whose figure is shown')
        pixel = read_pixel(file, int(shown['x']), int(shown['y']))
        radiance = json.loads(shown['radiance'])
        assert radiance == [pixel['R'], pixel['G'], pixel['B']], f'shown {radiance}, in the file {pixel}'
        compared.add((shown['x'], shown['y']))
        step(f'under the pointer at {shown["x"]}, {shown["y"]} of frame {shown["sequence"]}: {radiance}, as in frame.exr')
    assert len(compared) == 3


def check_looks(browser):
    mean = '''const canvas = document.getElementById('picture');
              const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
              return pixels.reduce((sum, value, i) => i % 4 === 3 ? sum : sum + value, 0) / (pixels.length * 3 / 4);'''
    choose = '''const input = document.getElementById(arguments[0]);
                input.value = arguments[1];
                input.dispatchEvent(new Event('input'));
                input.dispatchEvent(new Event('change'));'''

    def shown_with(control, value):
        before = browser.run(mean)
        browser.run(choose, control, value)
        changed = f'const before = {before};' + mean.replace('return', 'const now =') + 'return Math.abs(now - before) > 5 && now;'
        return browser.wait_for(changed, f'a picture that shows "{control}" at {value}')

    means = [shown_with('ev', value) for value in ('-3', '0', '3')]
    assert means[0] + 10 < means[1] < means[2] - 10, f'the exposure slider does nothing: {means}'
    looks = [shown_with('look', value) for value in ('false', 'provenance', 'tone')]
    assert browser.run('return document.querySelectorAll("#legend li").length') == 5
    assert abs(looks[0] - looks[2]) > 1 and abs(looks[1] - looks[2]) > 1, f'the looks are alike: {looks}'
    shown_with('ev', '0')
    assert not browser.run('return document.getElementById("legend").checkVisibility()'), 'a legend of nothing'
    step('mean code at -3, 0, +3 stops: ' + ', '.join(f'{m:.0f}' for m in means))


def check_light(program):
    """On a display of high dynamic range, which Chromium takes this one for, the picture is one with its light."""
    browser = Browser(1180, 1220, '--force-color-profile=hdr10')
    try:
        browser.open(program.url)
        look = '''const light = document.getElementById('light');
                  return light.hidden || !light.naturalWidth ? null
                      : {canvas: document.getElementById('picture').checkVisibility(), width: light.naturalWidth,
                         sequence: Number(document.getElementById('picture').dataset.sequence)};'''
        first = browser.wait_for(look, 'a picture with its light')
        assert not first['canvas'], 'both pictures are shown'
        browser.wait_for(f'return Number(document.getElementById("picture").dataset.sequence) > {first["sequence"] + 3}',
                         'newer pictures with their light')
        # The same bytes as the browser shows them, and with the chunk that says what they are renamed.
        means = browser.wait_for('''if (!window.means) {
            window.means = [];
            (async () => {
              const bytes = new Uint8Array(await (await fetch('frame.png')).arrayBuffer());
              const text = Array.from(bytes.slice(0, 200), (byte) => String.fromCharCode(byte)).join('');
              const chunk = text.indexOf('cICP') - 4, plain = new Uint8Array(bytes.length - 16);
              plain.set(bytes.subarray(0, chunk));
              plain.set(bytes.subarray(chunk + 16), chunk);
              for (const file of [bytes, plain]) {
                const bitmap = await createImageBitmap(new Blob([file], {type: 'image/png'}));
                const pen = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
                pen.drawImage(bitmap, 0, 0);
                const codes = pen.getImageData(0, 0, bitmap.width, bitmap.height).data;
                window.means.push(codes.reduce((sum, value, i) => i % 4 === 3 ? sum : sum + value, 0) / codes.length * 4 / 3);
              }
            })();
          }
          return window.means.length === 2 ? window.means : null;''', 'two pictures')
        assert abs(means[0] - means[1]) > 5, f'the browser does not heed what the file says of its light: {means}'
        browser.run('document.getElementById("look").value = "false"')
        browser.wait_for('return document.getElementById("picture").checkVisibility()', 'false colours on the canvas')
        complaints = [line for line in browser.complaints() if 'status of 503' not in line]
        assert not complaints, f'the browser complains: {complaints}'
        step(f'with an HDR display: {first["width"]} pixels wide with their light; mean code {means[0]:.0f}, as plain codes '
             f'{means[1]:.0f}')
    finally:
        browser.close()


def check_figures(browser):
    drawn = '''const canvas = document.getElementById('histogram');
               const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
               return pixels.filter((value, i) => i % 4 === 3 && value > 0).length;'''
    browser.wait_for(f'return (() => {{ {drawn} }})() > 2000', 'a histogram')
    tables = browser.run('''return Object.fromEntries(['frames', 'verdicts', 'drops', 'stages', 'provenance'].map(
        (id) => [id, document.getElementById(id).innerText]))''')
    for table, word in (('frames', 'captured'), ('verdicts', 'saturates at'), ('drops', 'shed'), ('stages', 'motion'),
                        ('provenance', 'carried')):
        assert word in tables[table], f'{table}: {tables[table]}'
    assert '-0.0 stops' not in tables['verdicts'], tables['verdicts']
    foreign = browser.run('''return performance.getEntriesByType('resource').map((e) => e.name)
                                      .filter((name) => !name.startsWith(location.origin))''')
    assert not foreign, f'the page loads from elsewhere: {foreign}'
    step('histogram and tables are filled; nothing is loaded from elsewhere')


def check_actions(browser, program, hdrcam):
    assert browser.run('return location.hash') == '', 'the token stays in the address bar'
    assert browser.run('return document.getElementById("token").value') == TOKEN
    browser.click('#record')
    file = browser.wait_for('return document.getElementById("recording").textContent', 'a recording')
    end = time.monotonic() + 60
    while program.status()['counters']['recorded'] < 10:
        assert time.monotonic() < end, 'nothing is recorded'
        time.sleep(0.2)
    browser.click('#record')
    browser.wait_for('return document.getElementById("recording").textContent === ""', 'the end of the recording')
    browser.run('document.getElementById("shutter").value = "2ms,8ms,24ms"')
    browser.click('#cycle')
    browser.wait_for('return document.getElementById("verdicts").innerText.includes("24 ms")', 'the new cycle')
    browser.run('document.getElementById("token").value = "not the token"')
    browser.click('#record')
    browser.wait_for('return document.getElementById("answer").textContent.includes("not the token")', 'a refusal')
    assert program.status()['recording'] == ''
    recorded = subprocess.run([hdrcam, 'info', file], capture_output=True, text=True)
    assert recorded.returncode == 0, recorded.stderr
    step(f'recorded and changed the cycle by buttons: {recorded.stdout.splitlines()[0]}')


def check_many_clients(program):
    """Rates of capture without and with the crowd; clients_test.py measures it for longer."""
    def rate(seconds):
        before = program.status()['counters']
        begin = time.monotonic()
        time.sleep(seconds)
        after = program.status()['counters']
        lost = sum(after[name] - before[name] for name in ('camera.lost', 'dropped.no_room'))
        return (after['captured'] - before['captured']) / (time.monotonic() - begin), lost

    alone, lost_alone = rate(10)
    crowd = Crowd(program.port)
    try:
        crowded, lost_crowded = rate(10)
    finally:
        pictures = crowd.leave()
    step(f'captured frames per second: {alone:.1f} alone, {crowded:.1f} with {LOOKING} clients ({sum(pictures)} pictures) and '
         f'{DAWDLING} that read a byte a second; frames lost: {lost_alone}, {lost_crowded}')
    assert crowded > 0.8 * alone, 'clients slow capture down'
    assert min(pictures) > 0, 'a client got no picture'


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    hdrcam = sys.argv[1]
    with tempfile.TemporaryDirectory(prefix='hdrcam-web-') as folder:
        program = Program(hdrcam, folder)
        try:
            browser = Browser(1180, 1220)
            try:
                print(f'Chromium {browser.version} on {program.url}', flush=True)
                browser.open(program.url + '#token=' + TOKEN)
                check_moving_picture(browser)
                check_figures(browser)
                check_looks(browser)
                check_radiance_under_pointer(browser, program)
                if len(sys.argv) > 2:
                    picture = pathlib.Path(sys.argv[2])
                    picture.parent.mkdir(parents=True, exist_ok=True)
                    picture.write_bytes(base64.b64decode(browser.screenshot()))
                    step(f'{picture}: {picture.stat().st_size} bytes')
                check_actions(browser, program, hdrcam)
                # What it was made to be refused, and the pictures before the first frame.
                expected = ('/record - Failed to load resource', 'status of 503')
                refused = [line for line in browser.complaints() if not any(words in line for words in expected)]
                assert not refused, f'the browser complains: {refused}'
                check_light(program)
                check_many_clients(program)
            finally:
                browser.close()
        finally:  # also where there is no browser
            summary = program.end()
        print(summary, end='')
    print('the live view works in the browser')


main()
