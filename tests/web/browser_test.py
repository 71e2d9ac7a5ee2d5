#!/usr/bin/env python3
"""The live view in a real browser: browser_test.py HDRCAM [SCREENSHOT.jpg]. Starts `hdrcam live` on the simulator and
Debian's Chromium without a screen, and ends with an error at the first thing that is not as docs/live-view.md says."""
import base64
import http.client
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

from browser import Browser
from exr_reader import read_pixel

TOKEN = 'token-of-the-browser-test'


class Program:
    """`hdrcam live` on the simulated camera, with a live view on a free port."""

    def __init__(self, program, folder):
        self.process = subprocess.Popen(
            [program, 'live', '--camera', 'sim:walk', '--format', 'RGB24', '--preset', 'fast', '--http', '127.0.0.1:0',
             '--http-token', TOKEN, '--http-record', f'{folder}/%03d.mkv', '--log-format', 'json'],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.log = []
        self.url = None
        for line in self.process.stderr:
            self.log.append(json.loads(line))
            found = re.search(r'live view: (http://127\.0\.0\.1:(\d+)/)', self.log[-1]['message'])
            if found:
                self.url, self.port = found[1], int(found[2])
                break
        assert self.url, f'no live view: {self.log}'
        threading.Thread(target=self.read_log, daemon=True).start()

    def read_log(self):
        for line in self.process.stderr:
            self.log.append(json.loads(line))  # every line is an object

    def get(self, path):
        with urllib.request.urlopen(self.url + path, timeout=60) as reply:
            return reply.headers, reply.read()

    def status(self):
        return json.loads(self.get('status.json')[1])

    def end(self):
        self.process.send_signal(signal.SIGINT)
        out, _ = self.process.communicate(timeout=120)
        assert self.process.returncode == 0, f'exit code {self.process.returncode}: {self.log[-3:]}'
        return out


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
        before = browser.run('return document.getElementById("picture").dataset.sequence')
        browser.run(choose, control, value)
        browser.wait_for(f'return document.getElementById("picture").dataset.sequence > {int(before) + 2}', 'a newer picture')
        return browser.run(mean)

    means = [shown_with('ev', value) for value in ('-3', '0', '3')]
    assert means[0] + 10 < means[1] < means[2] - 10, f'the exposure slider does nothing: {means}'
    looks = [shown_with('look', value) for value in ('false', 'provenance', 'tone')]
    assert browser.run('return document.querySelectorAll("#legend li").length') == 5
    assert abs(looks[0] - looks[2]) > 1 and abs(looks[1] - looks[2]) > 1, f'the looks are alike: {looks}'
    shown_with('ev', '0')
    assert not browser.run('return document.getElementById("legend").checkVisibility()'), 'a legend of nothing'
    step('mean code at -3, 0, +3 stops: ' + ', '.join(f'{m:.0f}' for m in means))


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
    """Rates of capture without and with twenty clients that ask as the page does, and five that read a byte a second. The
    clients would be other machines: here they have what processor time the program leaves."""
    def rate(seconds):
        before = program.status()['counters']
        begin = time.monotonic()
        time.sleep(seconds)
        after = program.status()['counters']
        lost = sum(after[name] - before[name] for name in ('camera.lost', 'dropped.no_room'))
        return (after['captured'] - before['captured']) / (time.monotonic() - begin), lost

    alone, lost_alone = rate(10)
    ending, pictures = threading.Event(), [0] * 20

    def yield_to_program():
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 19)

    def look(i):
        yield_to_program()
        client, newest = http.client.HTTPConnection('127.0.0.1', program.port, timeout=60), ''
        while not ending.wait(0.02):
            client.request('GET', '/frame.jpg?after=' + newest)
            reply = client.getresponse()
            pictures[i] += 1 if reply.read() else 0
            newest = reply.headers['X-Sequence'] or newest

    def dawdle():
        yield_to_program()
        with socket.create_connection(('127.0.0.1', program.port)) as client:
            client.sendall(b'GET /frame.exr HTTP/1.1\r\nHost: localhost\r\n\r\n')
            while not ending.wait(1):
                client.recv(1)

    threads = [threading.Thread(target=look, args=(i,)) for i in range(20)]
    threads += [threading.Thread(target=dawdle) for _ in range(5)]
    for thread in threads:
        thread.start()
    crowded, lost_crowded = rate(10)
    ending.set()
    for thread in threads:
        thread.join()
    step(f'captured frames per second: {alone:.1f} alone, {crowded:.1f} with 20 clients ({sum(pictures)} pictures) and 5 '
         f'that read a byte a second; frames lost: {lost_alone}, {lost_crowded}')
    assert crowded > 0.8 * alone, 'clients slow capture down'
    assert min(pictures) > 0, 'a client got no picture'


def main():
    hdrcam = sys.argv[1]
    with tempfile.TemporaryDirectory(prefix='hdrcam-web-') as folder:
        program = Program(hdrcam, folder)
        browser = Browser(1180, 1220)
        try:
            print(f'Chromium {browser.version} on {program.url}', flush=True)
            browser.open(program.url + '#token=' + TOKEN)
            check_moving_picture(browser)
            check_figures(browser)
            check_looks(browser)
            check_radiance_under_pointer(browser, program)
            if len(sys.argv) > 2:
                pathlib.Path(sys.argv[2]).write_bytes(base64.b64decode(browser.screenshot()))
                step(f'{sys.argv[2]}: {pathlib.Path(sys.argv[2]).stat().st_size} bytes')
            check_actions(browser, program, hdrcam)
            # What it was made to be refused, and the pictures before the first frame.
            expected = ('/record - Failed to load resource', 'status of 503')
            refused = [line for line in browser.complaints() if not any(words in line for words in expected)]
            assert not refused, f'the browser complains: {refused}'
            check_many_clients(program)
        finally:
            browser.close()
            summary = program.end()
        print(summary, end='')
    print('the live view works in the browser')


main()
