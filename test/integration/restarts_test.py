#!/usr/bin/python3
"""Nodes are killed in the middle of a drive and started again, from checkpoints and without: no place is ever mistaken for
another, and the map is as good as what was driven meanwhile allows. `scripts/endurance restarts` does it at more moments."""
import os
import sys

import rostest

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)
import restart_trials as trials  # noqa: E402

KILLED, BACK = 310, 325  # frames: the car turns a corner in between
AUTOSAVE_S = 5.0


class Restarts(harness.FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        bag = cls.path("town.bag")
        harness.write_town(bag, *trials.TOWN)
        cls.town = trials.Town(bag)
        cls.undisturbed = {}

    def error_undisturbed(self, odometry):
        if odometry not in self.undisturbed:
            self.undisturbed[odometry] = trials.undisturbed(self.town, self.path(odometry), odometry)[0]
        return self.undisturbed[odometry]

    def restarted(self, nodes, odometry="external", moments=(KILLED,), rate=100.0, checkpoints=True, lag=0):
        """A drive on which the nodes are killed, one after another at the moments, or all at the one there is."""
        name = self.id().rsplit(".", 1)[-1]
        folder = self.path(name)
        kept = {"map_dir": folder + "_map", "autosave_period": AUTOSAVE_S} if checkpoints else {}
        chain = trials.Chain(self.town, "/" + name, folder, odometry, lag, **kept)
        self.addCleanup(chain.end)
        for index, moment in enumerate(moments):
            killed = nodes if len(moments) == 1 else [nodes[index]]
            chain.restart(killed, moment, moment + BACK - KILLED, rate)
        chain.drive(len(self.town.frames), rate)
        chain.finish()
        views, decisions = chain.false_recalls()
        self.assertGreater(views[0], 50, "nothing was recalled")
        self.assertEqual((views[1], decisions[1]), (0, 0), "places were mistaken for others")
        return chain

    def check(self, chain, odometry="external", share=1.2, moments=1):
        error, poses = self.town.error(chain.trajectory + "_final.tum", odometry != "external")
        way = moments * self.town.way(KILLED, BACK)
        self.assertLess(error, share * self.error_undisturbed(odometry) + 0.1 * way, f"after {way:.1f} m without: {chain.words()}")
        return poses

    def test_local_view(self):
        chain = self.restarted(["ratslam_lv"])
        self.check(chain)
        self.assertEqual(chain.nodes["ratslam_lv"].count("resumed from the checkpoint at 1600000030"), 1)
        self.assertEqual(chain.nodes["ratslam_pc"].count("the local view started again"), 1)

    def test_pose_cells(self):
        chain = self.restarted(["ratslam_pc"])
        self.check(chain)
        self.assertEqual(chain.nodes["ratslam_pc"].count("resumed from the checkpoint at 1600000030"), 1)
        self.assertEqual(chain.nodes["ratslam_em"].count("the pose cells started again"), 1)

    def test_experience_map(self):
        chain = self.restarted(["ratslam_em"])
        poses = self.check(chain)
        lost = len(self.town.frames) - poses
        self.assertLessEqual(lost, 10 * AUTOSAVE_S + BACK - KILLED + 1)
        self.assertEqual(chain.nodes["ratslam_em"].count("resumed from the checkpoint at 1600000030"), 1)

    def test_pose_cells_whose_views_wait_for_odometry(self):
        chain = self.restarted(["ratslam_pc"], lag=3)
        self.check(chain)
        self.assertEqual(chain.nodes["ratslam_em"].count("time went back"), 0, chain.words())
        stamps = [state.header.stamp for state in chain.states]
        self.assertEqual(stamps, sorted(set(stamps)), "a decision was published twice")

    def test_all_at_once(self):
        chain = self.restarted(["ratslam_em", "ratslam_pc", "ratslam_lv"])
        poses = self.check(chain)
        self.assertLessEqual(len(self.town.frames) - poses, 10 * AUTOSAVE_S + BACK - KILLED + 1)

    def test_without_checkpoints(self):
        chain = self.restarted(["ratslam_lv", "ratslam_pc"], moments=(250, 330), checkpoints=False)
        self.check(chain, moments=2)
        self.assertEqual(chain.nodes["ratslam_em"].count("the pose cells started again"), 1)

    def test_experience_map_without_checkpoints(self):
        chain = self.restarted(["ratslam_em"], checkpoints=False)
        poses = self.check(chain)
        self.assertGreater(poses, len(self.town.frames) - BACK - 10, "the map that began anew is left")
        for words in ("map_dir is not set: experience_map starts without memory", "an experience that this map does not"):
            self.assertEqual(chain.nodes["ratslam_em"].count(words), 1, chain.words())

    def test_profile_odometry(self):
        self.check(self.restarted(["ratslam_vo"], "profile"), "profile")

    def test_orb_odometry(self):
        chain = self.restarted(["ratslam_orb_vo"], "orb", rate=30.0)
        self.check(chain, "orb", share=2.0)
        for listener in ("ratslam_pc", "ratslam_em"):
            self.assertEqual(chain.nodes[listener].count("odom: its source started anew"), 1, chain.words())

    def test_an_odometry_that_goes_back_to_its_origin(self):
        errors = []
        for reset in (None, KILLED):
            posed = self.town.with_poses(self.path(f"posed_{reset}.bag"), reset)
            errors.append(trials.undisturbed(posed, self.path(f"posed_{reset}"))[0])
        self.assertLess(errors[1], 2.0 * errors[0])


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "restarts", Restarts, sys.argv)
