"""A real browser, driven through chromedriver (W3C WebDriver over HTTP), with the standard library alone."""
import json
import subprocess
import time
import urllib.request

ELEMENT = 'element-6066-11e4-a52e-4f735466cecf'  # the key of an element's id, of the standard


class Browser:
    def __init__(self, width, height, *flags):
        self.driver = subprocess.Popen(['chromedriver', '--port=0'], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                       text=True)
        self.root = None
        for line in self.driver.stdout:
            if 'on port ' in line and 'successfully' in line:
                self.root = 'http://127.0.0.1:' + line.rstrip().rstrip('.').rsplit(' ', 1)[1]
                break
        assert self.root, 'chromedriver did not start'
        options = {'args': ['--headless=new', '--no-sandbox', '--disable-gpu', '--hide-scrollbars',
                            f'--window-size={width},{height}', *flags]}
        wish = {'capabilities': {'alwaysMatch': {'browserName': 'chrome', 'goog:chromeOptions': options,
                                                 'goog:loggingPrefs': {'browser': 'ALL'}}}}
        try:
            session = self.ask('POST', '/session', wish)
        except Exception:
            self.driver.terminate()
            raise
        self.version = session['capabilities']['browserVersion']
        self.session = '/session/' + session['sessionId']

    def ask(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.root + path, data, {'Content-Type': 'application/json'}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=120) as reply:
                return json.load(reply)['value']
        except urllib.error.HTTPError as error:
            raise AssertionError(f'{path}: {error.read().decode()[:500]}') from None

    def command(self, path, body):
        return self.ask('POST', self.session + path, body)

    def open(self, url):
        self.command('/url', {'url': url})

    def run(self, script, *arguments):
        return self.command('/execute/sync', {'script': script, 'args': list(arguments)})

    def element(self, selector):
        return self.command('/element', {'using': 'css selector', 'value': selector})[ELEMENT]

    def click(self, selector):
        self.command(f'/element/{self.element(selector)}/click', {})

    def point_at(self, selector, x, y):
        """Moves the pointer to (x, y) CSS pixels from the middle of an element."""
        move = {'type': 'pointerMove', 'duration': 50, 'x': x, 'y': y, 'origin': {ELEMENT: self.element(selector)}}
        self.command('/actions', {'actions': [{'type': 'pointer', 'id': 'mouse', 'parameters': {'pointerType': 'mouse'},
                                               'actions': [move]}]})

    def wait_for(self, script, what, seconds=60):
        """The first value of the script that is neither null nor false."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            value = self.run(script)
            if value:
                return value
            time.sleep(0.1)
        raise AssertionError(f'{what}: not within {seconds} s')

    def complaints(self):
        """Lines of the console that are errors."""
        return [line['message'] for line in self.command('/se/log', {'type': 'browser'}) if line['level'] == 'SEVERE']

    def screenshot(self):
        """A JPEG in base64."""
        return self.command('/goog/cdp/execute', {'cmd': 'Page.captureScreenshot',
                                                  'params': {'format': 'jpeg', 'quality': 82}})['data']

    def close(self):
        self.ask('DELETE', self.session)
        self.driver.terminate()
        self.driver.wait()
