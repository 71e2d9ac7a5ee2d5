"""`hdrcam live` on the simulated camera, with a live view on a free port. Standard library alone."""
import json
import re
import signal
import subprocess
import threading
import urllib.request

TOKEN = '100%-token-of-the-browser-test'  # with a % that is no escape


class Program:
    def __init__(self, program, folder, *more_arguments):
        self.process = subprocess.Popen(
            [program, 'live', '--camera', 'sim:walk', '--format', 'RGB24', '--preset', 'fast', '--http', '127.0.0.1:0',
             '--http-token', TOKEN, '--http-record', f'{folder}/%03d.mkv', '--log-format', 'json',
             '--compression', 'zip', *more_arguments],  # what exr_reader.py reads
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
