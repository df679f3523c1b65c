"""WheelSlipPlugin: lets wheels slip in proportion to force, as tires do."""

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._wheelslip import WheelSlipPlugin

GZ_REGISTER_MODEL_PLUGIN(WheelSlipPlugin)
