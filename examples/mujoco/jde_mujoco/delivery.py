"""Measurements on their way to their readers: late, at changing intervals, or lost. None overtakes an earlier one."""

from collections import deque


class Delivery:
    """The way of one sensor's measurements. Times are in seconds."""

    def __init__(self, delivery, random):
        """Take the latency, the jitter and the lost part of a robot's file."""
        self.delivery, self.random = delivery, random
        self.waiting = deque()

    def send(self, value, measured, now):
        """Send a value that is complete now."""
        delivery = self.delivery
        if self.random.random() < delivery["dropped"]:
            return
        arrives = now + delivery["latency"] + delivery["jitter"] * self.random.random()
        last = self.waiting[-1][0] if self.waiting else 0.0
        self.waiting.append((max(arrives, last), measured, value))

    def arrived(self, now):
        """Return each value that has arrived, with the time of its measurement."""
        while self.waiting and self.waiting[0][0] <= now + 1e-9:
            _, measured, value = self.waiting.popleft()
            yield value, measured

    def clear(self):
        """Forget what is on its way: its readers sleep."""
        self.waiting.clear()
