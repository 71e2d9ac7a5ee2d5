#!/usr/bin/env python3
"""What watching costs: clients_test.py HDRCAM [SECONDS [FLAGS OF LIVE..]]. Runs `hdrcam live` on the simulator and, turn by
turn, SECONDS (10) alone and SECONDS with 20 clients and 5 that read a byte a second (crowd.py), three times each. Prints
rates and the capture's jitter of both, and ends with an error where clients cost a captured frame. Exit code 2: the
machine loses frames without any client, so nothing can be said."""
import json
import sys
import tempfile
import time

from crowd import DAWDLING, LOOKING, Crowd
from program import Program

TURNS = 3
COUNTED = ('captured', 'emitted', 'camera.lost', 'camera.requests_late', 'dropped.no_room')


class Figures:
    """Of one condition, all turns together."""

    def __init__(self):
        self.seconds, self.counts, self.periods_us = 0, dict.fromkeys(COUNTED, 0), []

    def watch(self, program, seconds):
        before, begin = program.status()['counters'], time.monotonic()
        time.sleep(seconds)
        after, end = program.status()['counters'], time.monotonic()
        self.seconds += end - begin
        for name in COUNTED:
            self.counts[name] += after[name] - before[name]
        return begin, end

    def lost(self):
        return self.counts['camera.lost'] + self.counts['dropped.no_room']

    def line(self, name):
        late = sorted(abs(period - median(self.periods_us)) for period in self.periods_us)
        return (f'{name:10} {self.counts["captured"] / self.seconds:9.2f} {self.counts["emitted"] / self.seconds:9.2f} '
                f'{self.lost():6.0f} {self.counts["camera.requests_late"]:8.0f} {median(late) / 1e3:10.2f} '
                f'{late[len(late) * 99 // 100] / 1e3:10.2f} {late[-1] / 1e3:10.2f}')


def median(values):
    return sorted(values)[len(values) // 2]


def capture_ends_us(trace):
    """When the capture thread had each frame, by the trace's clock, whose zero is the program's start."""
    events = json.load(open(trace))['traceEvents']
    return [event['ts'] + event['dur'] for event in events if event.get('ph') == 'X' and event['name'] == 'capture']


def main():
    if len(sys.argv) < 2 or not all(word.isdigit() and int(word) > 0 for word in sys.argv[2:3]):
        sys.exit(__doc__)
    hdrcam, seconds, flags = sys.argv[1], int((sys.argv[2:] or [10])[0]), sys.argv[3:]
    alone, crowded, pictures, turns = Figures(), Figures(), [0] * LOOKING, []
    with tempfile.TemporaryDirectory(prefix='hdrcam-clients-') as folder:
        begin = time.monotonic()
        program = Program(hdrcam, folder, '--trace', f'{folder}/trace.json', *flags)
        try:
            while program.status()['frames'] < 10:
                time.sleep(0.2)
            for _ in range(TURNS):
                turns.append((alone, *alone.watch(program, seconds)))
                crowd = Crowd(program.port)
                try:
                    turns.append((crowded, *crowded.watch(program, seconds)))
                finally:
                    pictures = [a + b for a, b in zip(pictures, crowd.leave())]
        finally:
            summary = program.end()
        ends = [begin + end / 1e6 for end in capture_ends_us(f'{folder}/trace.json')]
    # The two clocks differ by the program's start, some milliseconds: the frames at a turn's edges are left out.
    for figures, begin, end in turns:
        times = [t for t in ends if begin + 0.2 < t < end - 0.2]
        figures.periods_us += [1e6 * (b - a) for a, b in zip(times, times[1:])]
    print(f'{"":10} {"captured":>9} {"emitted":>9} {"":6} {"late":>8} {"off the period, ms":>32}')
    print(f'{"":10} {"per s":>9} {"per s":>9} {"lost":>6} {"requests":>8} {"median":>10} {"p99":>10} {"most":>10}')
    print(alone.line('alone'))
    print(crowded.line('watched'))
    print(f'{LOOKING} clients got {sum(pictures)} pictures, each {min(pictures)} to {max(pictures)}; {DAWDLING} more read a '
          'byte a second')
    print(summary, end='')
    assert min(pictures) > 0, 'a client got no picture'
    if alone.lost() > 0:
        print('the machine loses frames without any client; try again when it is less busy')
        sys.exit(2)
    assert crowded.lost() == 0, 'clients cost captured frames'


main()
