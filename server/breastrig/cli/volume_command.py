"""The inside of a fitted body for finite elements: tetrahedra in the regions skin (with the fat under it), breast_L,
breast_R, chest_wall, trunk; which nodes are held, slide, or hold the breast; and the skin nodes' model vertices."""

import argparse
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_model, add_output_options, writing_file
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.folder.fit_folder import read_fit_folder
from breastrig.use.volume import breasts_said, volume_file, volume_of
from breastrig.volume.mesh_files import check_name
from breastrig.volume.volume_mesh import REGIONS, SOUND


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    add_model(parser, "the rig that the fit was made with")
    add_output_options(parser, "FILE", "torso.vtu, .msh, .scn (SOFA) or .feb (FEBio)")


def run(options: argparse.Namespace) -> int:
    """Writes the file and says what is in it; returns 0, or 3 when some tetrahedra are not sound."""
    check_name(options.output.name)
    with writing_file(options) as write:
        fit = read_fit_folder(options.fit, options.model)
        mesh = volume_of(fit)
        write(volume_file(fit, mesh, options.output.name))
        breasts = breasts_said(fit, mesh)
    say(*unchecked([options.fit]))
    litres = ", ".join(f"{name} {1e3 * mesh.volumes[mesh.inside(name)].sum():.2f} l" for name in REGIONS)
    print(
        f"{len(mesh.points)} nodes, {len(mesh.tetrahedra)} tetrahedra: {litres}; "
        f"scaled Jacobian from {mesh.scaled_jacobian.min():.2f}."
    )
    print(breasts, end="\n" if breasts else "")
    unsound = int((mesh.scaled_jacobian < SOUND).sum())
    if unsound:
        inverted = int((mesh.volumes <= 0.0).sum())
        say(
            f"{unsound} tetrahedra have a scaled Jacobian under {SOUND} ({inverted} are inverted), "
            "for the fitted skin is folded there; see scaled_jacobian in a .vtu file, and look at the fit.",
        )
    return 3 if unsound else 0
