"""Twenty clients that ask for pictures as the page does, and five that read a byte a second. They would be other
machines: here they have what processor time the program leaves."""
import http.client
import os
import socket
import threading

LOOKING, DAWDLING = 20, 5


class Crowd:
    """From its creation to leave()."""

    def __init__(self, port):
        self.port, self.ending, self.pictures = port, threading.Event(), [0] * LOOKING
        self.threads = [threading.Thread(target=self.look, args=(i,)) for i in range(LOOKING)]
        self.threads += [threading.Thread(target=self.dawdle) for _ in range(DAWDLING)]
        for thread in self.threads:
            thread.start()

    def leave(self):
        """The number of pictures that each of those who look has got."""
        self.ending.set()
        for thread in self.threads:
            thread.join()
        return self.pictures

    def look(self, i):
        self.yield_to_program()
        client, newest = http.client.HTTPConnection('127.0.0.1', self.port, timeout=60), ''
        while not self.ending.wait(0.02):
            client.request('GET', '/frame.jpg?after=' + newest)
            reply = client.getresponse()
            self.pictures[i] += 1 if reply.read() else 0
            newest = reply.headers['X-Sequence'] or newest

    def dawdle(self):
        self.yield_to_program()
        with socket.create_connection(('127.0.0.1', self.port)) as client:
            client.sendall(b'GET /frame.exr HTTP/1.1\r\nHost: localhost\r\n\r\n')
            while not self.ending.wait(1):
                client.recv(1)

    @staticmethod
    def yield_to_program():
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 19)
