r"""
Thermostat: a switch with hysteresis
====================================

The thermostat is the standard example of a hybrid system (R. Alur and others, Theoretical Computer
Science 138, 1995, 3–34). A heater goes on when the room falls to 19 °C and off when it reaches
21 °C. With a time constant :math:`\tau = 2` h and a heater that is worth 30 K,

.. math:: \tau \dot T = T_o + 30\,h - T, \qquad h \in \{0, 1\}.

Outside at :math:`T_o` one cycle of heating and cooling takes

.. math:: \tau\left(\ln\frac{T_o + 30 - 19}{T_o + 30 - 21} + \ln\frac{21 - T_o}{19 - T_o}\right).

The heater is a discrete state; two jumps set it.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

T = ss.state("T")
(heater,) = ss.discrete(heater=1.0)
(To,) = ss.parameters(To=5.0)
on = ss.Jump("on", when=T - 19, direction="falling", set={heater: 1})
off = ss.Jump("off", when=T - 21, direction="rising", set={heater: 0})


def room(outside):
    return ss.System({T: (outside + 30 * heater - T) / 2}, jumps=[on, off])


# %%
# Left: a day between -4 °C at midnight and 12 °C at noon. Right: the length of a cycle over a
# constant temperature outside.

left, right = plt.figure().subplots(1, 2)
day = room(4 - 8 * np.cos(2 * np.pi * ss.t / 24))
sol = ss.solve_ivp(day, (0, 24), [19, 1], t_eval=np.linspace(0, 24, 3000))
left.plot(sol.t, sol.y[0])
left.fill_between(sol.t, 18.5, 18.5 + 0.3 * sol.y[1], color="C1", lw=0, label="heater on")
left.set(xlabel="time [h]", ylabel="temperature $T$ [°C]", xlim=(0, 24), ylim=(18.5, 21.8))
left.set_xticks(range(0, 25, 6))
left.legend(loc="upper right")


def exact(outside):
    heats = np.log((outside + 30 - 19) / (outside + 30 - 21))
    return 2 * heats, 2 * np.log((21 - outside) / (19 - outside))


worst, outsides = 0.0, np.linspace(-8, 18, 27)
for outside in outsides:
    jumps = ss.solve_ivp(room(To).with_parameters(To=outside), (0, 40), [19, 1]).transitions
    off_at, on_at = (jumps["t"][jumps["contact"] == name] for name in ("off", "on"))
    found = on_at[1] - on_at[0]
    worst = max(worst, abs(found - sum(exact(outside))), abs(off_at[0] - exact(outside)[0]))
    right.plot(outside, found, "o", color="C0")
right.plot(outsides, np.add(*exact(outsides)), color="C0", lw=1, label="closed form")
right.set(xlabel="temperature outside $T_o$ [°C]", ylabel="length of a cycle [h]", ylim=(0, None))
right.legend()

print(f"largest error of a time of switching: {worst:.1e} h")
assert worst < 1e-12
plt.show()
