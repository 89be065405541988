"""Remeshing on several ranks in the program: the same bytes as on one, each rank with its blocks alone."""
import json

from on_ranks import OnRanks, main


class Remesh(OnRanks):
    def on_ranks(self, ranks, *arguments):
        run = super().on_ranks(ranks, *arguments)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def report(self, name):
        report = json.loads((self.folder / name).read_text())["remesh"]
        for passed in report["passes"]:
            passed["seconds"] = 0
        for means in report["before"], report["after"]:
            means["mean_length"], means["mean_quality"] = round(means["mean_length"], 9), round(means["mean_quality"], 9)
        return report

    def test_any_number_of_ranks_writes_the_same_bytes(self):
        for shape, size, block in ((("box", "--elements", 600), 0.17, 800), (("rectangle", "--elements", 300), 0.03, 700)):
            self.camber("generate", *shape, "-o", "in.meshb")
            asked = "remesh", "in.meshb", "--metric", size, "--blocks", block
            self.camber(*asked, "-o", "one.meshb", "--report", "one.json")
            for ranks in (2, 3):
                with self.subTest(shape=shape[0], ranks=ranks):
                    run = self.on_ranks(ranks, *asked, "-o", "ranks.meshb", "--report", "ranks.json")
                    self.assertEqual(run.stdout.count("edges of unit length"), 1)
                    self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))
                    self.assertEqual(self.report("one.json"), self.report("ranks.json"))
        self.assertEqual([p.name for p in self.folder.iterdir() if "part" in p.name], [])

    def test_what_is_not_rows_alone_is_written_as_a_whole(self):
        self.camber("generate", "rectangle", "--elements", 300, "-o", "in.meshb")
        asked = "remesh", "in.meshb", "--metric", 0.05, "--blocks", 300
        self.camber(*asked, "-o", "one.mesh", "--output-metric", "one.solb")
        self.on_ranks(2, *asked, "-o", "ranks.mesh", "--output-metric", "ranks.solb")
        self.assertEqual(self.bytes_of("one.mesh"), self.bytes_of("ranks.mesh"))
        self.assertEqual(self.bytes_of("one.solb"), self.bytes_of("ranks.solb"))

    def test_a_required_distance_from_the_geometry_is_measured(self):
        self.camber("generate", "annulus", "--elements", 300, "-o", "in.meshb")
        asked = "remesh", "in.meshb", "--metric", 0.3, "--blocks", 100, "--geometry-error", 0.001
        self.camber(*asked, "-o", "one.meshb", "--report", "one.json")
        self.on_ranks(2, *asked, "-o", "ranks.meshb", "--report", "ranks.json")
        self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))
        one, ranks = (json.loads((self.folder / name).read_text())["boundary"] for name in ("one.json", "ranks.json"))
        self.assertEqual(one["geometry_error"], ranks["geometry_error"])
        self.assertLessEqual(ranks["geometry_error"]["reached"], 0.001)


if __name__ == "__main__":
    main()
