"""A shield in a small grid world with doors that may slam: a random agent never makes its prospects worse.

    python minigrid_shield.py 1000000
"""

import random
import sys
import time

import meliora

WORLD = """mdp
// Rooms behind doors. The floor is slippery: a move may go one cell further. A door in the middle column may slam
// behind the agent, and then stays shut.
module agent
  x : [0..7] init 0;
  y : [0..7] init 0;
  shut : bool init false;
  [east] x<7 & !(x=3 & shut) -> 0.8: (x'=x+1) & (shut'=(shut | x=3)) + 0.2: (x'=min(7,x+2)) & (shut'=(shut | x=3));
  [west] x>0 & !(x=4 & shut) -> 0.8: (x'=x-1) + 0.2: (x'=(shut & x<=5 & x>=4) ? 4 : max(0,x-2));
  [north] y<7 -> 0.8: (y'=y+1) + 0.2: (y'=min(7,y+2));
  [south] y>0 -> 0.8: (y'=y-1) + 0.2: (y'=max(0,y-2));
  [lift] x=0 & y=7 & !shut -> 0.5: (x'=7) & (y'=0) & (shut'=true) + 0.5: (x'=1) & (y'=0) & (shut'=true);
endmodule
"""
WISHES = """
objective Water = F (x=0 & y=3);
objective Gold = F (x=7 & y=7);
objective Key = F (x=1 & y=1 & shut);
objective Crown = F (x=6 & y=1 & shut);
prefer Key, Crown > Water; prefer Key > Gold;
"""


model = meliora.Model.from_string(WORLD)
analysis = model.check(meliora.Preferences.from_string(WISHES))
strategy = analysis.strategy("spi")
shield = strategy.shield()
best = {tuple(state.values()): analysis.most_preferred(state) for state in model.explore().states}
moves = {
    (state, action): ([p for p, _ in found], [tuple(after.values()) for _, after in found])
    for state in best
    for action, found in strategy.successors(dict(zip(model.variables, state))).items()
}
worse = {"Key": {"Water", "Gold"}, "Crown": {"Water"}}
steps, draw = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000, random.Random(1)


def run(shielded: bool) -> tuple[int, int, float]:
    """Returns the numbers of weakening and improving steps of a random agent, and the time of the shield."""
    weakening, improving, spent = 0, 0, 0.0
    for step in range(steps):
        if step % 100 == 0:
            state = draw.choice(list(best))
            shield.reset(state)
        action = draw.choice([action for action in model.actions if (state, action) in moves])
        if shielded:
            began = time.perf_counter()
            action = shield.correct(state, action)
            spent += time.perf_counter() - began
        weights, targets = moves[state, action]
        after = draw.choices(targets, weights)[0]
        weakening += any(new in worse.get(old, ()) for old in best[state] for new in best[after])
        improving += any(old in worse.get(new, ()) for old in best[state] for new in best[after])
        state = after
    return weakening, improving, spent


for shielded in (False, True):
    weakening, improving, spent = run(shielded)
    print(f"{'with' if shielded else 'without'} shield: {weakening} of {steps} steps weaken, {improving} improve")
print(f"{spent / steps * 1e6:.1f} microseconds per call", file=sys.stderr)
