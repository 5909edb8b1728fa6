"""Control of the turbine: blade pitch, generator torque, yaw control by pitch, generator; libraries."""

from fowtlib.components.servo.baseline import BaselineController
from fowtlib.components.servo.bladed import BladedController
from fowtlib.components.servo.estimator import ScheduledEstimator, StateEstimator
from fowtlib.components.servo.estimator_table import EstimatorTable, read_estimators
from fowtlib.components.servo.gain_table import GainTable, read_gains
from fowtlib.components.servo.generator import Generator
from fowtlib.components.servo.individual_pitch import IndividualPitchController
from fowtlib.components.servo.nacelle_velocity import NacelleVelocity
from fowtlib.components.servo.peak_shaving import LeastPitch, PeakShaving, read_least_pitch
from fowtlib.components.servo.pitch_controller import FLOATING_GAINS, ONSHORE_GAINS, PitchController
from fowtlib.components.servo.safety_system import SafetySystem
from fowtlib.components.servo.sampled import SampledPitchController, SampledTorqueController
from fowtlib.components.servo.set_point_feedback import SetPointFeedback
from fowtlib.components.servo.state_feedback import DemandedController, PitchDrive, ScheduledFeedback
from fowtlib.components.servo.supervisor import Supervisor
from fowtlib.components.servo.torque_controller import TorqueController
from fowtlib.components.servo.torque_law import TorqueLaw, torque_of
from fowtlib.components.servo.turbine_controller import TurbineController
from fowtlib.components.servo.yaw_controller import YawController

__all__ = [
    "FLOATING_GAINS",
    "ONSHORE_GAINS",
    "BaselineController",
    "BladedController",
    "DemandedController",
    "EstimatorTable",
    "GainTable",
    "Generator",
    "IndividualPitchController",
    "NacelleVelocity",
    "LeastPitch",
    "PeakShaving",
    "PitchController",
    "PitchDrive",
    "SafetySystem",
    "SampledPitchController",
    "SampledTorqueController",
    "ScheduledEstimator",
    "ScheduledFeedback",
    "SetPointFeedback",
    "StateEstimator",
    "Supervisor",
    "TorqueController",
    "TorqueLaw",
    "TurbineController",
    "YawController",
    "read_estimators",
    "read_gains",
    "torque_of",
    "read_least_pitch",
]
