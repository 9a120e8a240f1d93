"""The Python module: the models by their parameters' names, arrays without copies, states, tools under one roof."""

import importlib
import os
import subprocess
import sys

import numpy as np
import pytest

from conftest import SOURCE

for place in (
    os.path.join(SOURCE, "devel", "lib", "python3", "dist-packages"),
    os.path.join(SOURCE, "build", "python"),
):
    if os.path.isdir(os.path.join(place, "ratslam")) and place not in sys.path:
        sys.path.append(place)
ratslam = pytest.importorskip("ratslam", reason="the Python module is not built")


def test_activity_is_a_view_that_follows_the_network():
    network = ratslam.PoseCellNetwork(pc_dim_xy=15, pc_dim_th=24, pc_cell_x_size=0.5)
    activity = network.activity
    assert activity.shape == (24, 15, 15) and activity.dtype == np.float64 and not activity.flags.owndata
    assert activity.sum() == pytest.approx(1.0, abs=1e-12) and activity[12, 7, 7] == 1.0
    network.inject(heading=3, y=2, x=1, energy=0.5)
    assert activity[3, 2, 1] > 0.0
    network.attract()
    assert np.shares_memory(activity, network.activity)
    assert activity.sum() == pytest.approx(1.0, abs=1e-12)
    with pytest.raises(ValueError):
        activity[0, 0, 0] = 1.0
    del network
    assert activity.sum() == pytest.approx(1.0, abs=1e-12)


def test_packets_move_along_their_heading_and_turn():
    network = ratslam.PoseCellNetwork(pc_dim_xy=21, pc_cell_x_size=1.0, pc_openratslam_corner=False)
    for _ in range(10):
        network.step(0.3, 0.0)
    assert network.estimate.x == pytest.approx(10 - 3.0, abs=0.2), "it starts facing backwards: layer 18 of 36"
    assert network.estimate.y == pytest.approx(10, abs=0.2)
    for _ in range(9):
        network.step(0.0, np.pi / 18)
    assert network.estimate.th == pytest.approx(27, abs=0.3)


@pytest.mark.parametrize("descriptor", ["blocks", "orientation"])
def test_likeness_is_largest_where_the_view_was_learned(descriptor):
    sizes = {"template_x_size": 32, "template_y_size": 8, "vt_shift_match": 2, "vt_step_match": 1}
    cells = ratslam.LocalViewCells(vt_descriptor=descriptor, vt_match_threshold=0.0, **sizes)
    assert cells.likeness.size == 0
    images = np.random.default_rng(1).integers(0, 256, (5, 120, 320), np.uint8)
    for frame, image in enumerate(images):
        cells.observe(frame, image)
    assert cells.likeness.shape[1] == len(cells) == 5 and cells.likeness.dtype == np.float32
    assert cells.likeness.max(axis=0).argmax() == 4
    again = ratslam.LocalViewCells(**cells.parameters)
    again.load(cells.save())
    assert np.array_equal(again.likeness, cells.likeness)


def test_a_state_saved_goes_on_as_if_it_had_never_stopped():
    whole, first = (ratslam.PoseCellNetwork(pc_dim_xy=11) for _ in range(2))
    for network in (whole, first):
        for step in range(20):
            network.step(0.2, 0.01 * step)
    second = ratslam.PoseCellNetwork(pc_dim_xy=11)
    before = second.activity
    second.load(first.save())
    assert before.sum() == pytest.approx(1.0), "a view of what was before stays whole"
    for network in (whole, second):
        for step in range(20):
            network.step(0.1, -0.02 * step)
    assert np.array_equal(whole.activity, second.activity) and whole.save() == second.save()
    with pytest.raises(ValueError, match="pc_dim_xy = 11, but it is 13"):
        ratslam.PoseCellNetwork(pc_dim_xy=13).load(first.save())
    with pytest.raises(RuntimeError):
        second.load(b"nothing of the kind")


def test_a_state_of_other_parameters_is_refused_and_changes_nothing():
    map_state = ratslam.ExperienceMap(exp_solver="graph").save()
    with pytest.raises(ValueError, match="exp_solver = graph, but it is relaxation here"):
        ratslam.ExperienceMap(exp_solver="relaxation").load(map_state)
    cells = ratslam.LocalViewCells(**VIEW)
    cells.observe(0, textured(1))
    with pytest.raises(ValueError, match="vt_match_threshold"):
        cells.load(ratslam.LocalViewCells(**{**VIEW, "vt_match_threshold": 0.05}).save())
    assert len(cells) == 1


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"pc_dim_xyz": 3}, "pc_dim_xyz.*did you mean pc_dim_xy"),
        ({"pc_dim_xy": 0}, "pc_dim_xy.*0"),
        ({"pc_dim_xy": 2.5}, "whole number"),
        ({"pc_cell_x_size": float("nan")}, "pc_cell_x_size"),
        ({"pc_cell_x_size": "wide"}, "not a number"),
    ],
)
def test_bad_parameters_are_named(settings, words):
    with pytest.raises(ValueError, match=words):
        ratslam.PoseCellNetwork(**settings)


def test_a_number_may_have_a_form_of_its_own():
    class Float(float):  # as numpy's since 2.0
        def __repr__(self):
            return f"np.float64({float(self)})"

    assert ratslam.PoseCellNetwork(pc_cell_x_size=Float(2.5)).parameters["pc_cell_x_size"] == 2.5


def test_activity_of_another_shape_and_cells_outside_are_refused():
    network = ratslam.PoseCellNetwork(pc_dim_xy=11, pc_dim_th=12)
    with pytest.raises(ValueError, match=r"\(12, 11, 11\)"):
        network.set_activity(np.ones((11, 11, 12)))
    for bad in (np.zeros((12, 11, 11)), -np.ones((12, 11, 11)), np.full((12, 11, 11), np.nan), np.full((12, 11, 11), 1e-313)):
        with pytest.raises(ValueError):
            network.set_activity(bad)
    with pytest.raises(ValueError, match="heading: value 12"):
        network.inject(12, 0, 0, 0.1)
    packet = np.zeros((12, 11, 11))
    packet[4, 3, 2] = 2.0
    network.set_activity(packet)
    assert network.activity[4, 3, 2] == 1.0 and tuple(network.estimate) == pytest.approx((2, 3, 4))


VIEW = {"template_x_size": 20, "template_y_size": 6, "vt_match_threshold": 0.02, "vt_shift_match": 2, "vt_step_match": 1}


def textured(seed):
    return np.random.RandomState(seed).randint(0, 256, (60, 160)).astype(np.uint8)


def test_views_are_learned_and_recalled():
    cells = ratslam.LocalViewCells(**VIEW)
    assert cells.parameters["template_x_size"] == 20
    first, second = cells.observe(0.0, textured(1)), cells.observe(0.1, textured(2))
    again = cells.observe(200000000, np.dstack([textured(1)] * 3))
    assert (first.learned, second.learned, again.learned) == (True, True, False)
    assert (first.id, second.id, again.id, len(cells)) == (0, 1, 0, 2) and again.stamp == 200000000
    assert cells.template(1).shape == (6, 20) and cells.template(1).dtype == np.uint8
    strided = np.ascontiguousarray(np.repeat(textured(2), 2, axis=1))[:, ::2]
    assert cells.observe(0.3, strided).id == 1
    for bad in (np.zeros((3, 4, 5), np.uint8), np.zeros((3, 4)), np.zeros((0, 4), np.uint8)):
        with pytest.raises(ValueError, match="image"):
            cells.observe(0.4, bad)
    with pytest.raises(ValueError, match="stamp"):
        cells.observe("now", textured(1))
    restored = ratslam.LocalViewCells(**VIEW)
    restored.load(cells.save())
    assert restored.observe(0.5, textured(2)).id == 1 and len(restored) == 2


def test_the_models_together_close_a_square():
    cells = ratslam.PoseCells(pc_dim_xy=11, pc_cell_x_size=0.5)
    experiences = ratslam.ExperienceMap(exp_initial_em_deg=0.0, exp_recall_sigma=0.3)
    experiences.start(0.0)
    for step in range(41):
        stamp, side = 0.1 * (step + 1), step % 10
        forward, rotation = 0.4, np.pi / 2 if side == 9 else 0.0
        experiences.integrate(stamp, forward, rotation)
        cells.integrate(forward, rotation)
        cells.activate(ratslam.ViewEvent(stamp, step % 40))
        action = cells.decide()
        if action.kind != "none":
            experiences.apply(action)
    experiences.settle()
    assert experiences.experiences.shape[1] == 5 and len(experiences.experiences) >= 30
    links = experiences.links
    assert links["ends"].shape == (len(links["recall"]), 2) and links["measured"].shape[1] == 5
    assert experiences.final_trajectory.shape == experiences.online_trajectory.shape
    again = ratslam.ExperienceMap(exp_initial_em_deg=0.0, exp_recall_sigma=0.3)
    again.load(experiences.save())
    assert np.array_equal(again.experiences, experiences.experiences)
    with pytest.raises(ValueError, match="create_edge"):
        ratslam.Action(0, "invent", 0, 1)


def test_the_whole_system_frame_by_frame():
    strip = np.random.RandomState(3).randint(0, 256, (60, 160 + 40 * 6)).astype(np.uint8)
    system = ratslam.Pipeline(odometry="external", pc_dim_xy=11, pc_cell_x_size=0.5, **VIEW)
    assert system.parameters["pc_dim_xy"] == 11
    learned = []
    for lap in range(2):
        for index in range(40):
            stamp = 0.1 * (40 * lap + index)
            system.add_odometry(stamp, speed=1.0, yaw_rate=2 * np.pi / 4)
            done = system.add_image(stamp, strip[:, 6 * index : 6 * index + 160])
            assert len(done["views"]) == 1 and len(done["actions"]) == 1 and done["told"] == ""
        learned.append(system.templates)
    assert learned[0] > 10 and learned[1] == learned[0], "the second lap is recalled"
    assert system.activity.shape == (36, 11, 11)
    assert system.links["recall"].any() and len(system.experiences) < 60
    assert system.final_trajectory.shape[1] == 6
    assert "late" in system.add_image(0.1 * 79 - 0.45, strip[:, :160])["told"]
    for settings, words in (({"odometry": "orb"}, "needs the camera"), ({"odometry": "topic"}, "one of profile, orb, or external")):
        with pytest.raises(ValueError, match=words):
            ratslam.Pipeline(**settings, **VIEW)
    with pytest.raises(ValueError, match="no parameter has this name"):
        ratslam.Pipeline(pc_dim_zz=3)


def test_images_need_not_outlive_the_call():
    """A temporary array, and a buffer that is filled anew, whose memory the next image has again."""
    random = np.random.RandomState(5)
    buffer = np.empty((60, 160), np.uint8)
    for reused in (False, True):
        system = ratslam.Pipeline(odometry="external", **VIEW)
        for index in range(30):
            system.add_odometry(0.1 * index, speed=1.0, yaw_rate=0.0)
            image = random.randint(0, 256, buffer.shape).astype(np.uint8)
            buffer[:] = image
            assert system.add_image(0.1 * index, buffer if reused else image.copy())["told"] == ""
            del image
        assert system.templates >= 28


def test_odometry_that_is_not_used_is_said():
    with pytest.raises(ValueError, match="profile, orb, or external"):
        ratslam.Pipeline("profiles", **VIEW)
    with pytest.raises(ValueError, match="external"):
        ratslam.Pipeline("profile", **VIEW).add_odometry(0, 1.0, 0.0)
    pipeline = ratslam.Pipeline("external", **VIEW)
    assert pipeline.add_odometry(0.1, 1.0, 0.0)["told"] == ""
    assert "speed is not finite" in pipeline.add_odometry(0.2, float("nan"), 0.0)["told"]
    assert "not newer" in pipeline.add_odometry(0.1, 1.0, 0.0)["told"]
    for beyond in (10**30, 2**63 - 1, -(2**63)):
        with pytest.raises(ValueError, match=f"stamp: value {beyond}"):
            pipeline.add_odometry(beyond, 1.0, 0.0)


def test_a_list_may_be_an_array():
    camera = {"camera_fx": 300, "camera_fy": 300, "camera_cx": 160, "camera_cy": 120, "camera_width_px": 320}
    pipeline = ratslam.Pipeline(**VIEW, **camera, camera_height_px=240, camera_distortion=np.array([0.1, -0.2]))
    assert pipeline.parameters["camera_distortion"] == [0.1, -0.2]


def test_tools_are_the_tools_themselves():
    by_module = importlib.import_module("ratslam.tools.trajectory.geometry")
    by_name = importlib.import_module("ratslam_tools.trajectory.geometry")
    assert by_module is by_name and by_name.__spec__.name == "ratslam_tools.trajectory.geometry"
    assert ratslam.tools.errors.InputError is sys.modules["ratslam_tools.errors"].InputError
    with pytest.raises(ImportError):
        importlib.import_module("ratslam.tools.nothing")
    with pytest.raises(ratslam.tools.errors.InputError, match="no such folder"):
        ratslam.read_run("/nowhere")


def test_tools_are_loaded_when_they_are_asked_for():
    code = (
        "import sys, ratslam; assert 'ratslam_tools' not in sys.modules; "
        "assert ratslam.tools.trajectory.read_trajectory and ratslam.tools.evaluation.evaluate_ape; "
        "assert ratslam.tools.datasets and ratslam.tools.runs; "
        "from ratslam.tools.runs import run_folder; assert run_folder is sys.modules['ratslam_tools.runs.run_folder']; "
        "assert not hasattr(ratslam, 'nothing') and not hasattr(ratslam.tools, 'nothing')"
    )
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(filter(None, sys.path)))
    done = subprocess.run([sys.executable, "-c", code], env=environment, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0, done.stderr
