"""The commands about compliances from displacement fields."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from stiffkit.cli.arguments import json_option, output_option, results_folder


@click.command()
@click.argument("spec", type=click.Path(path_type=Path))
@output_option("Directory for the results; by default stiffkit-NAME here, and none with --json.")
@json_option
def identify(spec: Path, output: Path | None, as_json: bool) -> None:
    """Compliance of a link from displacement fields, with error bars.

    SPEC is a YAML file that names the fields, their load cases and the nodes to read. Writes
    NAME.link.yaml, which robot files take by name, and report.html, which needs no network.

    Example:  stiffkit identify foot.yaml -o out/foot
    """
    from stiffkit.cli.show import progress, tell
    from stiffkit.cli.show_identified import show_identified
    from stiffkit.identify import as_json as plain
    from stiffkit.identify import identify_link, read_spec

    checked = read_spec(spec)
    target = results_folder(checked.name, output, as_json=as_json)
    link_file = f"{checked.name}.link.yaml"
    with progress(sys.stderr.isatty()) as report:
        found = identify_link(checked, report)
        if target is not None:
            from stiffkit.report import write_identify_page
            from stiffkit.study import identification, whole_directory

            found.check()
            with whole_directory(target, identification(link_file)) as work:
                found.write(work / link_file)
                report("writing the report", 0.9)
                write_identify_page(found, work / "report.html")
    written = (
        []
        if target is None
        else [f"compliance: {target / link_file}", f"open {target / 'report.html'}"]
    )
    tell(found, show_identified, plain, as_json=as_json, written=written)


@click.command()
@click.argument("link", type=click.Path(path_type=Path))
@click.option("--noise", metavar="LENGTH", help="Noise of a node's displacement, such as 5e-5mm.")
@click.option("--size", metavar="LENGTH", help="Edge of a cubic field of nodes, such as 10mm.")
@click.option("--nodes", type=click.IntRange(min=1), help="Number of nodes of that field.")
@click.option(
    "--accuracy",
    type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
    default=0.002,
    show_default=True,
    help="Relative error of a deflection that is wanted.",
)
@json_option
def advise(
    link: Path,
    noise: str | None,
    size: str | None,
    nodes: int | None,
    accuracy: float,
    as_json: bool,
) -> None:
    """How large the loads of an identification should be, and why.

    LINK is a file with the compliance that is expected: a link file, which needs --noise, --size
    and --nodes beside it, or the specification of an earlier identification, which has all of it.

    Example:  stiffkit advise foot.link.yaml --noise 5e-5mm --size 10mm --nodes 1331
    """
    from stiffkit.cli.show import tell
    from stiffkit.cli.show_identified import advice_as_json, show_advice
    from stiffkit.identify import advise_link
    from stiffkit.units import LENGTH, to_si

    found = advise_link(
        link,
        sigma=None if noise is None else to_si(noise, LENGTH),
        size=None if size is None else to_si(size, LENGTH),
        count=nodes,
        accuracy=accuracy,
    )
    tell(found, show_advice, advice_as_json, as_json=as_json)
