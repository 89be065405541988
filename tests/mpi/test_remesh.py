"""Remeshing on several ranks: the same bytes as on one rank, while each rank stores only its blocks."""
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

    def test_remeshed_mesh_and_report_do_not_depend_on_number_of_ranks(self):
        for shape, size, block in ((("box", "--elements", 600), 0.17, 800), (("rectangle", "--elements", 300), 0.03, 700)):
            self.camber("generate", *shape, "-o", "in.meshb")
            command = "remesh", "in.meshb", "--metric", size, "--blocks", block
            self.camber(*command, "-o", "one.meshb", "--report", "one.json")
            for ranks in (2, 3):
                with self.subTest(shape=shape[0], ranks=ranks):
                    run = self.on_ranks(ranks, *command, "-o", "ranks.meshb", "--report", "ranks.json")
                    self.assertEqual(run.stdout.count("edges of unit length"), 1)
                    self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))
                    self.assertEqual(self.report("one.json"), self.report("ranks.json"))
        self.assertEqual([p.name for p in self.folder.iterdir() if "part" in p.name], [])

    def test_text_mesh_and_metric_output_do_not_depend_on_number_of_ranks(self):
        self.camber("generate", "rectangle", "--elements", 300, "-o", "in.meshb")
        command = "remesh", "in.meshb", "--metric", 0.05, "--blocks", 300
        self.camber(*command, "-o", "one.mesh", "--output-metric", "one.solb")
        self.on_ranks(2, *command, "-o", "ranks.mesh", "--output-metric", "ranks.solb")
        self.assertEqual(self.bytes_of("one.mesh"), self.bytes_of("ranks.mesh"))
        self.assertEqual(self.bytes_of("one.solb"), self.bytes_of("ranks.solb"))

    def test_ranks_measure_the_distance_from_the_geometry(self):
        self.camber("generate", "annulus", "--elements", 300, "-o", "in.meshb")
        command = "remesh", "in.meshb", "--metric", 0.3, "--blocks", 100, "--geometry-error", 0.001
        self.camber(*command, "-o", "one.meshb", "--report", "one.json")
        self.on_ranks(2, *command, "-o", "ranks.meshb", "--report", "ranks.json")
        self.assertEqual(self.bytes_of("one.meshb"), self.bytes_of("ranks.meshb"))
        one, ranks = (json.loads((self.folder / name).read_text())["boundary"] for name in ("one.json", "ranks.json"))
        self.assertEqual(one["geometry_error"], ranks["geometry_error"])
        self.assertLessEqual(ranks["geometry_error"]["reached"], 0.001)


if __name__ == "__main__":
    main()
