"""The FMU of the tests: a description, the C code of controller.c, an archive.

python tests/fmu/controller_fmu.py FILE [VERSION]      writes one, of FMI 2 or 3
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from fowtlib.components.fmu.running import platform_folder
from fowtlib.language.native import compiler

SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
HERE = Path(__file__).parent
UNITS = """
<UnitDefinitions>
  <Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit>
  <Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>
  <Unit name="kNm"><BaseUnit kg="1" m="2" s="-2" factor="1000"/></Unit>
</UnitDefinitions>"""
PARAMETERS = {
    "period": (3, 0.0125), "k_p": (4, 0.006275604), "k_i": (5, 0.0008965149), "pitch_start": (6, 0.0),
    "torque_start": (7, 0.0), "speed_start": (8, 0.0), "trouble_time": (9, 1e9),
}  # fmt: skip


def description_2(step: str = 'stepSize="0.0125"') -> str:
    def variable(name: str, number: int, attributes: str, kind: str) -> str:
        return f'<ScalarVariable name="{name}" valueReference="{number}" {attributes}>{kind}</ScalarVariable>'

    parameter = 'causality="parameter" variability="fixed"'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="controller" guid="fowtlib-test-controller">
<CoSimulation modelIdentifier="controller" canHandleVariableCommunicationStepSize="true"/>{UNITS}
<DefaultExperiment {step}/>
<ModelVariables>
{variable("generator.speed", 0, 'causality="input" variability="continuous"', '<Real unit="rpm" start="0"/>')}
{variable("mode", 101, 'causality="input" variability="discrete"', '<Integer start="2"/>')}
{variable("enabled", 200, 'causality="input" variability="discrete"', '<Boolean start="true"/>')}
{variable("pitch[1]", 1, 'causality="output" variability="discrete" description="blade pitch"', '<Real unit="deg"/>')}
{variable("torque", 2, 'causality="output" variability="discrete"', '<Real unit="kNm"/>')}
{variable("mode_out", 101, 'causality="output" variability="discrete"', "<Integer/>")}
{variable("samples", 102, 'causality="output" variability="discrete"', "<Integer/>")}
{variable("active", 200, 'causality="output" variability="discrete"', "<Boolean/>")}
{variable("instances", 10, 'causality="output" variability="discrete"', "<Real/>")}
{"".join(variable(name, number, parameter, f'<Real start="{value}"/>') for name, (number, value) in PARAMETERS.items())}
{variable("trouble", 100, parameter, '<Integer start="0"/>')}
</ModelVariables>
<ModelStructure>
<Outputs>{"".join(f'<Unknown index="{i}"/>' for i in range(4, 10))}</Outputs>
<InitialUnknowns>{"".join(f'<Unknown index="{i}"/>' for i in range(4, 10))}</InitialUnknowns>
</ModelStructure>
</fmiModelDescription>
"""


def description_3(step: str = 'stepSize="0.0125"') -> str:
    size = '<Dimension start="2"/><Dimension start="2"/>'
    outputs = (1, 2, 401, 102, 402, 10, 301)
    parameter = 'causality="parameter" variability="fixed"'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="controller" instantiationToken="fowtlib-test-controller">
<CoSimulation modelIdentifier="controller" canHandleVariableCommunicationStepSize="true"/>{UNITS}
<TypeDefinitions><Float64Type name="Angle" unit="deg"/></TypeDefinitions>
<DefaultExperiment {step}/>
<ModelVariables>
<Float64 name="time" valueReference="1000" causality="independent"/>
<Float64 name="generator.speed" valueReference="0" causality="input" unit="rpm" start="0"/>
<Int32 name="mode" valueReference="101" causality="input" start="2"/>
<Boolean name="enabled" valueReference="200" causality="input" start="true"/>
<Float64 name="array_in" valueReference="300" causality="input" start="0 0 0 0">{size}</Float64>
<Float64 name="pitch[1]" valueReference="1" causality="output" variability="discrete" declaredType="Angle"/>
<Float64 name="torque" valueReference="2" causality="output" variability="discrete" unit="kNm"/>
<Int32 name="mode_out" valueReference="401" causality="output"/>
<Int32 name="samples" valueReference="102" causality="output"/>
<Boolean name="active" valueReference="402" causality="output"/>
<Float64 name="instances" valueReference="10" causality="output" variability="discrete"/>
<Float64 name="array_out" valueReference="301" causality="output">{size}</Float64>
{"".join(f'<Float64 name="{name}" valueReference="{number}" {parameter} start="{value}"/>'
         for name, (number, value) in PARAMETERS.items())}
<Int32 name="trouble" valueReference="100" {parameter} start="0"/>
</ModelVariables>
<ModelStructure>
{"".join(f'<Output valueReference="{number}"/>' for number in outputs)}
{"".join(f'<InitialUnknown valueReference="{number}"/>' for number in outputs)}
</ModelStructure>
</fmiModelDescription>
"""


def compiled(version: int, folder: Path) -> bytes:
    """The compiled controller; functions that it does not have return an error."""
    import fmpy

    headers = Path(fmpy.__file__).parent / "c-code"
    source, header = (HERE / "controller.c").read_text(), (headers / f"fmi{version}Functions.h").read_text()
    wanted = set(re.findall(rf"FMI{version}_Export\s+\w+TYPE\s+(\w+);", header))
    defined = set(re.findall(rf"(?:^|\s)\**(fmi{version}\w+)\(", source))
    stubs, target = folder / f"stubs_{version}.c", folder / f"controller_{version}{SUFFIX}"
    stubs.write_text("".join(f"int {name}(void) {{ return 3; }}\n" for name in sorted(wanted - defined)))
    options = ["-std=c11", "-O1", "-fPIC", "-shared", f"-DVERSION={version}", f"-I{headers}"]
    subprocess.run([*compiler(), *options, HERE / "controller.c", stubs, "-o", target, "-lm"], check=True)
    return target.read_bytes()


def files(version: int, library: bytes, description: str = "") -> dict[str, bytes | str]:
    """The files of the FMU, by their names in the archive."""
    text = description or (description_2() if version == 2 else description_3())
    return {"modelDescription.xml": text, f"binaries/{platform_folder(f'{version}.0')}/controller{SUFFIX}": library}


def write(path: Path, content: Mapping[str, bytes | str]) -> Path:
    """A zip archive of files."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for name, one in content.items():
            target.writestr(name, one)
    return path


def make(path: Path, version: int = 2) -> Path:
    """Compile and pack it."""
    with tempfile.TemporaryDirectory() as folder:
        return write(path, files(version, compiled(version, Path(folder))))


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    make(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 2)
