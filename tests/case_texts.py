"""Case files that several tests begin with."""


def swing_case(radius: float = 0.01, elements: int = 3, ends: tuple[str, str] = ("pin", "tip")) -> str:
    """A rubber rod of 1 m that swings from its first end for 20 steps."""
    first, last = ends
    return f"""[section.rubber]
kind = "circle"
radius = {radius}
E = 5e6
nu = 0.5
rho = 1100
[[rod]]
name = "rod"
section = "rubber"
line = [[0, 0, 0], [1, 0, 0]]
ends = ["{first}", "{last}"]
elements = {elements}
[[support]]
node = "{first}"
type = "pin"
[gravity]
value = [0, 0, -9.81]
[dynamics]
t_end = 0.2
dt = 0.01
"""
