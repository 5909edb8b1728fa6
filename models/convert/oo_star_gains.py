"""Gains of two rotors on the OO-Star over the wind, data/oo_star/gains.json: linear-quadratic, from the model itself.

The weights are those of O. El Beshbichi, thesis, Univ. of Stavanger (2023), table 8.6. The gains in its table 8.7 have
the rows "rated" and "above rated" interchanged: by |K_e| = sqrt(Q_e / R) of the weights the integral gains are 0.0014
and 0.032 in this order. Below rated the integrals have a small weight, as for the spar, see two_rotor_spar_gains.py.
"""

from two_rotor_spar_gains import DATA, write_gains

# wind: weights of yaw, yaw rate, speeds, integrals; of the pitches
WEIGHTS = {10.5: ((500, 1, 0, 1e-4), 1000), 12.5: ((2500, 2500, 500, 0.01), 5000), 99: ((1000, 1000, 1, 1.0), 1000)}

if __name__ == "__main__":
    write_gains("oo_star_rigid", WEIGHTS, DATA / "oo_star" / "gains.json")
