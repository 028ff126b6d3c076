"""Reads xacro files, from which robot descriptions in URDF are made."""

import os
from collections.abc import Mapping


def read_xacro(
    path: str | os.PathLike[str],
    mappings: Mapping[str, str | float] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
) -> str:
    """Returns the URDF text of a xacro file, for `register_robot(urdf=…)`. Not for several threads at once.

    Needs the package `xacro`: `pip install revprio[xacro]`.

    Args:
        path: The file.
        mappings: Values of the arguments of the file (`<xacro:arg …/>`).
        packages: Directories of the ROS packages that the file names by `$(find …)`. Others are looked for where
            ROS has them.

    Raises:
        ImportError: The package `xacro` is not installed.
        ValueError: The file cannot be expanded.

    """
    try:
        import xacro  # noqa: PLC0415
        from xacro import substitution_args  # noqa: PLC0415
    except ImportError as error:
        message = "xacro files need the package `xacro`: pip install revprio[xacro]"
        raise ImportError(message) from error

    # xacro reads relative paths from the directory of the file that names them.
    directories = {name: os.path.abspath(directory) for name, directory in (packages or {}).items()}
    # xacro evaluates texts only.
    values = {name: str(value) for name, value in (mappings or {}).items()}
    look_up = substitution_args._eval_find
    unknown: list[str] = []

    def find(package: str) -> str:
        if package in directories:
            return directories[package]
        try:
            return str(look_up(package))
        except Exception:
            unknown.append(package)
            raise

    # The package has no public way to say where other packages are.
    substitution_args._eval_find = find
    try:
        return str(xacro.process_file(os.fspath(path), mappings=values).toxml())
    except Exception as error:  # The package raises errors of several unrelated types.
        remedy = [f"state the directory of the ROS package `{package}` in `packages`" for package in unknown]
        message = f"{os.fspath(path)}: {'; '.join(remedy) or error}"
        raise ValueError(message) from error
    finally:
        substitution_args._eval_find = look_up
