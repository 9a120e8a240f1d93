"""A progress line on stderr with rate and time left, shown only where stderr is a terminal."""

import sys
import time


class Progress:
    """Counts towards `total`; draws at most a few times a second."""

    INTERVAL_S = 0.2
    WIDTH = 30

    def __init__(self, total: int, what: str, stream=None):
        self.total, self.what = total, what
        self.stream = sys.stderr if stream is None else stream
        self.enabled = self.stream.isatty()
        self.begin = time.monotonic()
        self.drawn = -self.INTERVAL_S
        self.done = 0

    def advance(self, count: int = 1) -> None:
        """Counts `count` more steps as done."""
        self.done += count
        elapsed = time.monotonic() - self.begin
        if self.enabled and (elapsed - self.drawn >= self.INTERVAL_S or self.done >= self.total):
            self.drawn = elapsed
            self.stream.write("\r" + self.line(elapsed))
            self.stream.flush()

    def line(self, elapsed: float) -> str:
        """Bar, count, rate and time left after `elapsed` seconds."""
        filled = self.WIDTH * self.done // max(self.total, 1)
        rate = self.done / elapsed if elapsed > 0 else 0.0
        left = f"{(self.total - self.done) / rate:.0f} s left" if rate > 0 else "-"
        bar = "#" * filled + "." * (self.WIDTH - filled)
        return f"{self.what} [{bar}] {self.done}/{self.total}  {rate:.3g}/s  {left}   "

    def close(self) -> None:
        """Ends the line."""
        if self.enabled:
            self.stream.write("\n")
