"""Separate thresholds to enter and to leave, so that a precondition near its limit does not chatter."""


class Hysteresis:
    """A condition that begins and ends to hold at different values."""

    def __init__(self) -> None:
        self.holds = False

    def below(self, value: float, enter: float, leave: float) -> bool:
        """Begin to hold when `value` falls to `enter`, and end when it rises above `leave`, the greater of the two.

        A NaN ends it. Returns whether it holds.
        """
        self.holds = value <= (max(leave, enter) if self.holds else enter)
        return self.holds

    def above(self, value: float, enter: float, leave: float) -> bool:
        """Begin to hold when `value` rises to `enter`, and end when it falls below `leave`, the lesser of the two.

        A NaN ends it. Returns whether it holds.
        """
        self.holds = value >= (min(leave, enter) if self.holds else enter)
        return self.holds

    def reset(self) -> None:
        """Make it not hold, for example after a sleep."""
        self.holds = False
