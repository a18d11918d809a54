"""The command about links from CAD parts."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stiffkit.cli.arguments import json_option, output_option, results_folder
from stiffkit.errors import CadError

if TYPE_CHECKING:
    from stiffkit.fea import Part


@click.command()
@click.argument("source", metavar="SPEC", type=click.Path(path_type=Path))
@click.option("--faces", is_flag=True, help="List the part's faces instead; SPEC may be the part.")
@output_option(
    "Directory for the results; by default stiffkit-NAME here, and none with --json or --faces."
)
@json_option
def link(source: Path, faces: bool, output: Path | None, as_json: bool) -> None:
    """Compliance and superelement of a link from a CAD part, with an estimated error.

    SPEC is a YAML file that names the part, its material and its two interfaces. Writes
    NAME.link.yaml, which robot files take by name, report.html, which needs no network, and
    figures. What has been solved before is not solved again.

    Examples:  stiffkit link foot.step --faces -o out/faces,  stiffkit link foot.yaml -o out/foot
    """
    if faces:
        _list_faces(source, output, as_json)
        return
    from stiffkit.fea.link_spec import read_link_spec
    from stiffkit.fea.sources import CAD_SUFFIXES

    if source.suffix.lower() in CAD_SUFFIXES:
        raise CadError(
            f"{source} is a part, and a link needs its material and two interfaces",
            mend=f"look at its faces with 'stiffkit link {source} --faces', and write a "
            "specification of them",
        )
    checked = read_link_spec(source)
    from stiffkit.cli.show import progress, tell
    from stiffkit.cli.show_link import show_link
    from stiffkit.fea.cad_link import as_json as plain
    from stiffkit.fea.cad_link import link_from_cad

    target = results_folder(checked.name, output, as_json=as_json)
    link_file = f"{checked.name}.link.yaml"
    with progress(sys.stderr.isatty()) as report:
        found = link_from_cad(checked, report)
        if target is not None:
            from stiffkit.plots import write_link_figures
            from stiffkit.report import write_link_page
            from stiffkit.study import cad_link, whole_directory

            with whole_directory(target, cad_link(link_file)) as work:
                found.write(work / link_file)
                report("drawing figures", 0.95)
                figures = write_link_figures(found, work / "figures")
                report("writing the report", 0.98)
                write_link_page(found, figures, work / "report.html")
    written = (
        [] if target is None else [f"link: {target / link_file}", f"open {target / 'report.html'}"]
    )
    tell(found, show_link, plain, as_json=as_json, written=written)


def _list_faces(source: Path, output: Path | None, as_json: bool) -> None:
    part = _part(source)
    if output is not None:
        from stiffkit.plots import write_face_figure
        from stiffkit.study import FACES, whole_directory

        with whole_directory(output, FACES) as work:
            write_face_figure(part, work / "faces")
    from stiffkit.cli.show import tell
    from stiffkit.cli.show_link import faces_as_json, show_faces

    written = [] if output is None else [f"picture: {output / 'faces.png'}"]
    tell(part, show_faces, faces_as_json, as_json=as_json, written=written)


def _part(source: Path) -> Part:
    """Return the part that a path or a specification names."""
    from stiffkit.fea import read_step
    from stiffkit.fea.child import check_installed
    from stiffkit.fea.link_spec import read_link_spec
    from stiffkit.fea.prepared import read_part
    from stiffkit.fea.sources import CAD_SUFFIXES

    check_installed()
    if source.suffix.lower() not in CAD_SUFFIXES:
        return read_part(read_link_spec(source))
    return read_step(source)
