r"""
Pressure relief valve: impacts, rest on the seat, lift-off
==========================================================

A pressure relief valve is a body on a spring that a pressure lifts from its seat. C. Hős and A. R.
Champneys studied the model (Physica D 241, 2012, 2068–2076); F. Hegedűs and others time their
solver of ensembles with it. With the displacement :math:`y_1`, its rate :math:`y_2` and the
pressure :math:`y_3`,

.. math::

   \dot y_1 = y_2, \qquad \dot y_2 = -\kappa y_2 - (y_1 + \delta) + y_3, \qquad
   \dot y_3 = \beta\,(q - y_1\sqrt{y_3}),

where :math:`\kappa = 1.25`, :math:`\delta = 10`, :math:`\beta = 20`. At :math:`y_1 = 0` the body
hits its seat and keeps a part :math:`r = 0.8` of its speed. At a low flow :math:`q` the impacts
accumulate, and the valve stays shut: the seat carries :math:`\delta - y_3`, and the pressure rises
at the rate :math:`\beta q` until that vanishes.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

y, v, p = ss.states("y v p")
q = ss.parameter("q", 0.1)
seat = ss.Stop("seat", gap=y, acts={v: 1}, restitution=0.8)
valve = ss.System(
    {y: v, v: -1.25 * v - (y + 10) + p, p: 20 * (q - y * np.sqrt(p))},
    stops=[seat],
    start=[0.2, 0, 1],
)

# %%
# Left: at :math:`q = 0.1` the valve, started below its opening pressure, chatters to rest, stays
# shut and then chatters for ever. Right: the maxima of the displacement after 60 time units. At the
# lowest flows the valve comes to rest on its seat in every cycle (orange). At the highest it rests
# open, at :math:`y_1\sqrt{y_1 + \delta} = q` (line).

left, right = plt.figure().subplots(1, 2)
sol = ss.solve_ivp(valve, (0, 8), t_eval=np.linspace(0, 8, 8001))
closed = sol.y[3] == 1
left.plot(sol.t, sol.y[0], label="displacement $y_1$ [–]")
left.plot(sol.t, sol.forces[0] / 20, color="C1", label="reaction of the seat / 20 [–]")
left.set(xlabel="time [–]", xlim=(0, 8), ylim=(0, None))
left.legend(loc="upper right")


def landings(of):
    at = of.transitions
    return at[at["contact"] == "seat.landing"], at[at["contact"] == "seat.lift-off"]


shut = []
for flow in np.geomspace(0.01, 10, 121):
    found = ss.solve_ivp(
        valve.with_parameters(q=flow), (0, 70), [0.2, 0, 10], events=ss.event(v, "falling")
    )
    # Between the impacts of chatter the displacement has maxima without number.
    late = (found.t_events[0] > 60) & (found.y_events[0][:, 0] > 1e-4)
    rests = (landings(found)[0]["t"] > 60).any()
    shut += [flow] if rests else []
    maxima = found.y_events[0][late, 0]
    color = "C1" if rests else "C0"
    right.plot(np.full(len(maxima), flow), maxima, ".", color=color, ms=1.5)
heights = np.geomspace(0.01, 3, 100)
flows = heights * np.sqrt(heights + 10)
right.plot(flows, heights, color="gray", lw=0.7)
right.set(xlabel="flow $q$ [–]", ylabel="maxima of $y_1$ [–]", xlim=(0.01, 10), ylim=(1e-4, 10))
right.set(xscale="log", yscale="log")

landed, lifted = landings(sol)
lasts = lifted["t"][0] - landed["t"][0]
exact = (10 - landed["y"][0, 2]) / (20 * 0.1)
first = sol.transitions[0]
print(f"shut for {lasts:.10f}, closed form {exact:.10f}")
print(f"impulse of the first impact {first['impulse'][0]:.6f}; rests up to q = {max(shut):.3f}")
assert abs(lasts - exact) < 1e-9 and 0.015 < max(shut) < 0.025
assert np.allclose(sol.forces[0], np.where(closed, 10 - sol.y[2], 0), rtol=0, atol=1e-9)
assert abs(first["impulse"][0] + 1.8 * first["y_before"][1]) < 1e-12
plt.show()
