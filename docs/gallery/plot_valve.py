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
q = ss.parameter("q", 0.2)
seat = ss.Stop("seat", gap=y, acts={v: 1}, restitution=0.8)
valve = ss.System(
    {y: v, v: -1.25 * v - (y + 10) + p, p: 20 * (q - y * np.sqrt(p))},
    stops=[seat],
    start=[0.2, 0, 10],
)

# %%
# Left: displacement and reaction of the seat at :math:`q = 0.2`. Right: the maxima of the
# displacement over the flow, after a transient of 60 time units. Where the flow is high the valve
# rests open, at :math:`y_1\sqrt{y_1 + \delta} = q`.

left, right = plt.figure().subplots(1, 2)
sol = ss.solve_ivp(valve, (0, 12), t_eval=np.linspace(0, 12, 6001))
closed = sol.y[3] == 1
left.plot(sol.t, sol.y[0], label="displacement $y_1$ [–]")
left.plot(sol.t, sol.forces[0] / 20, color="C1", label="reaction / 20 [–]")
left.set(xlabel="time [–]", xlim=(0, 12), ylim=(0, None))
left.legend(loc="upper right")

maxima = ss.event(v, "falling")
flows = np.linspace(0.3, 10, 195)
resting = []
for flow in flows:
    found = ss.solve_ivp(valve.with_parameters(q=flow), (0, 70), events=maxima)
    returns = found.y_events[0][found.t_events[0] > 60, 0]
    right.plot(np.full(len(returns), flow), returns, ".", color="C0", ms=1.5)
    landings = found.transitions[found.transitions["contact"] == "seat.landing"]
    resting.append(bool((landings["t"] > 60).any()))
last = flows[np.array(resting)].max()
right.axvline(last, color="C1", lw=1, ls="--")
right.text(last, 3.2, " rests on its seat below", color="C1", va="top")
right.set(xlabel="flow $q$ [–]", ylabel="maxima of $y_1$ [–]", xlim=(0, 10), ylim=(0, None))

events = sol.transitions
landed = events[events["contact"] == "seat.landing"]
lifted = events[events["contact"] == "seat.lift-off"]
count = min(len(landed), len(lifted))
shut = lifted["t"][:count] - landed["t"][:count]
exact = (10 - landed["y"][:count, 2]) / (20 * 0.2)
print(f"{count} rests; shut for {shut[0]:.10f}, closed form {exact[0]:.10f}")
print(f"impulse of the first impact {events['impulse'][0, 0]:.6f}; rests up to q = {last:.2f}")
assert count > 1 and np.allclose(shut, exact, rtol=0, atol=1e-9)
assert np.allclose(sol.forces[0], np.where(closed, 10 - sol.y[2], 0), rtol=0, atol=1e-9)
assert np.allclose(events["impulse"][0, 0], -1.8 * events["y_before"][0, 1], rtol=1e-12)
plt.show()
