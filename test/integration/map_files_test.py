#!/usr/bin/python3
"""The checkpoints of running nodes, and the map file that a service writes, on a full disk, in a folder that cannot be written, with
two writers, and damaged: one clear line each, no node ends, and the last good checkpoint is what a restart goes on from."""
import contextlib
import fcntl
import os
import resource
import shutil
import sqlite3
import subprocess
import sys

import rospy
import rostest
from ratslam_ros.srv import MapPath

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import chain  # noqa: E402  (lies beside this file)
import harness  # noqa: E402

PARTS = {"ratslam_em": "experience_map", "ratslam_pc": "pose_cells", "ratslam_lv": "local_view"}
SMALL = 16384  # bytes: less than any checkpoint has


def mere_user():
    """Root writes where it may not: words before a command that make it give that up, none where it cannot."""
    words = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]
    can = os.geteuid() == 0 and shutil.which("setpriv") and subprocess.run([*words, "true"], check=False).returncode == 0
    return words if can else []


MERE_USER = mere_user()


class MapFiles(chain.ChainTest):
    BEFORE = MERE_USER
    PARAMETERS = {"autosave_period": 1.0}

    def setUp(self):
        super().setUp()
        os.makedirs(self.map_dir)

    def tearDown(self):
        super().tearDown()
        os.chmod(self.map_dir, 0o755)

    def nodes_of_map(self, **parameters):
        """@return the nodes that keep a part of the map, by name"""
        return self.chain(*PARTS, **parameters)

    def writer(self, name, alias="", **parameters):
        """One more node that keeps its part in the same folder."""
        return self.start(name, f"__name:={self.named(name)}{alias}", map_dir=self.map_dir, **{**self.PARAMETERS, **parameters})

    def save(self, path):
        rospy.wait_for_service(self.root + "/ExperienceMap/SaveMap", 15.0)
        return rospy.ServiceProxy(self.root + "/ExperienceMap/SaveMap", MapPath)(path)

    def refused(self, expected, path):
        answer = self.save(path)
        self.assertFalse(answer.success, answer.message)
        self.assertRegex(answer.message, expected)
        self.assertNotIn("\n", answer.message)

    def stamps(self, part):
        """{file: stamp of its checkpoint, in seconds of the drive}"""
        found = {}
        for turn in "ab":
            path = os.path.join(self.map_dir, f"{part}.{turn}.db")
            if os.path.exists(path):
                with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as database:
                    tables = database.execute("SELECT 1 FROM sqlite_master WHERE name = 'checkpoint'").fetchall()
                    rows = database.execute("SELECT stamp FROM checkpoint").fetchall() if tables else []
                if rows:  # neither table nor row while the first one is written
                    found[path] = (rows[0][0] - harness.START_NS) / 1e9
        return found

    def written_up_to(self, second):
        for part in PARTS.values():
            self.assertTrue(harness.wait_until(lambda p=part: max(self.stamps(p).values(), default=0.0) >= second), part)

    def resumes(self, nodes, seconds):
        """@param seconds  by node"""
        for name, node in nodes.items():
            words = f"{PARTS[name]}.[ab].db: resumed from the checkpoint at {1000 + seconds[name]:.0f}.0"
            self.assertEqual(node.count(words), 1, node.output())

    def lost(self, nodes, why):
        """Each node has said once why its checkpoint was lost."""
        for name, node in nodes.items():
            self.assertTrue(node.said(f"checkpoint lost: {self.map_dir}/{PARTS[name]}.[ab].db: .*({why})"), node.output())
            self.assertEqual(node.count("checkpoint lost"), 1, node.output())

    def test_full_disk(self):
        nodes = self.nodes_of_map()
        self.drive(45)
        self.written_up_to(4)
        self.assertTrue(self.save("lap.db").success)
        kept = self.stamps("local_view")
        whole = harness.contents(os.path.join(self.map_dir, "lap.db"))
        for node in nodes.values():
            resource.prlimit(node.process.pid, resource.RLIMIT_FSIZE, (SMALL, resource.RLIM_INFINITY))
        self.drive(20)
        self.lost(nodes, "the disk is full")
        self.assertEqual(self.stamps("local_view"), kept)
        self.refused("the disk is full", "lap.db")
        self.assertEqual(harness.contents(os.path.join(self.map_dir, "lap.db")), whole)
        self.assertEqual([name for name in os.listdir(self.map_dir) if ".part" in name], [])
        self.kill(nodes)
        nodes = self.nodes_of_map()
        self.resumes(nodes, dict.fromkeys(PARTS, 4))
        self.drive(20)
        self.written_up_to(8)
        for node in nodes.values():
            self.assertEqual(node.count("damaged|lost"), 0, node.output())

    def test_room_again(self):
        nodes = self.nodes_of_map()
        self.drive(45)
        self.written_up_to(4)
        for room in (SMALL, resource.RLIM_INFINITY):
            for node in nodes.values():
                resource.prlimit(node.process.pid, resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
            self.drive(20)
            self.lost(nodes, "the disk is full")
        self.written_up_to(8)
        for node in nodes.values():
            self.ends_well(node)

    def test_folder_that_cannot_be_written(self):
        if os.geteuid() == 0 and not MERE_USER:
            self.skipTest("root writes everywhere here")
        os.chmod(self.map_dir, 0o555)
        for name in PARTS:
            node = self.writer(name)
            self.assertEqual(node.ended(), 1, node.output())
            self.assertEqual(node.count(f"FATAL.* {self.map_dir}/{PARTS[name]}.a.db: cannot write beside it: Permission denied"), 1, node.output())
        os.chmod(self.map_dir, 0o755)
        nodes = self.nodes_of_map()
        self.drive(45)
        self.written_up_to(4)
        os.chmod(self.map_dir, 0o555)
        self.drive(20)
        self.lost(nodes, "cannot be written")
        self.refused("cannot write beside it: Permission denied", "lap.db")
        self.kill(nodes)
        # What is only read need not be writable.
        nodes = self.nodes_of_map(localise_only="true")
        self.resumes(nodes, dict.fromkeys(PARTS, 4))
        self.drive(20)
        for node in nodes.values():
            self.assertEqual(node.count("lost|cannot (be written|write)"), 0, node.output())
            self.ends_well(node)
        self.assertEqual(max(self.stamps("local_view").values()), 4)

    def test_two_writers(self):
        nodes = self.nodes_of_map()
        self.drive(25)
        for name, part in PARTS.items():
            second = self.writer(name, "_second", topic_root=self.root + "/second")
            self.assertEqual(second.ended(), 1, second.output())
            self.assertEqual(second.count(f"FATAL.* {self.map_dir}/{part}.a.db: another program writes to it; one map has one writer"), 1,
                             second.output())
        with open(os.path.join(self.map_dir, "lap.db.lock"), "w", encoding="ascii") as other:
            fcntl.flock(other, fcntl.LOCK_EX)
            self.refused("lap.db: another program writes to it; one map has one writer", "lap.db")
        self.assertTrue(self.save("lap.db").success)
        self.drive(20)
        self.written_up_to(4)
        for node in nodes.values():
            self.assertEqual(node.count("lost|damaged"), 0, node.output())
            self.ends_well(node)

    def test_damaged(self):
        nodes = self.nodes_of_map()
        self.drive(45)
        self.written_up_to(4)
        self.kill(nodes)
        damaged, left = {}, {}
        for name, part in PARTS.items():
            stamps = self.stamps(part)
            damaged[name] = max(stamps, key=stamps.get)
            left[name] = min(stamps.values())
            os.truncate(damaged[name], os.path.getsize(damaged[name]) // 2)
        nodes = self.nodes_of_map()
        self.resumes(nodes, left)
        self.drive(30)
        self.written_up_to(6)
        for name, node in nodes.items():
            self.assertEqual(node.count(f"WARN.* {damaged[name]}: "), 1, node.output())
            self.assertEqual(node.count("lost"), 0, node.output())
            self.assertTrue(os.path.exists(damaged[name] + ".damaged"))


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "map_files", MapFiles, sys.argv)
