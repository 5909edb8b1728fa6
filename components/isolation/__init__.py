"""Native code made elsewhere, run in a process of its own or in this one."""

from fowtlib.components.isolation.folders import private_folder, remove
from fowtlib.components.isolation.process import Inside, Outside, Unit

__all__ = ["Inside", "Outside", "Unit", "private_folder", "remove"]
