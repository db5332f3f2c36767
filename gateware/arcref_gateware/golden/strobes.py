"""Golden model of the strobe: which sample each rising edge picks, and which edges are refused."""

from collections import deque

from arcref_gateware.pending_strobes import LEAST_WAIT_WORDS, PENDING_STROBES


class StrobeModel:
    """Turns rising edges of the strobe into due samples, in order.

    A strobe is refused when another one fell due earlier in the same word, or when `PENDING_STROBES` wait for their
    delay. A waiting strobe makes room for one that arrives in the word after the one in which it is due.
    """

    def __init__(self, samples_per_word: int, delay: int):
        self.samples_per_word = samples_per_word
        self.delay = delay
        self.waiting: deque[int] = deque()
        self.last_due_word = -1

    def run(self, rises) -> tuple[list[int], list[int]]:
        """Take the samples of rising edges. Returns `(due samples, words in which a strobe was refused)`."""
        coarse, fine = divmod(self.delay, self.samples_per_word)
        due_samples, refused_words = [], []
        for rise in rises:
            arrival = (rise + fine) // self.samples_per_word
            due_word = arrival + coarse
            while self.waiting and self.waiting[0] + coarse < arrival:
                self.waiting.popleft()
            waits = coarse >= LEAST_WAIT_WORDS
            if due_word == self.last_due_word or (waits and len(self.waiting) == PENDING_STROBES):
                refused_words.append(arrival)
            else:
                due_samples.append(rise + self.delay)
                if waits:
                    self.waiting.append(arrival)
            self.last_due_word = due_word
        return due_samples, refused_words
