"""The program on several ranks: output, exit codes and a single rank."""
from on_ranks import CAMBER, OnRanks, main


class Program(OnRanks):
    def test_only_the_first_rank_prints(self):
        for arguments in ("--help", "--version"):
            alone = self.run_line(CAMBER, arguments)
            self.assertEqual(self.on_ranks(3, arguments).stdout, alone.stdout)

    def test_error_is_printed_once_and_sets_the_exit_code(self):
        alone = self.run_line(CAMBER, "curv")
        together = self.on_ranks(3, "curv")
        self.assertEqual(together.returncode, alone.returncode)
        self.assertEqual(together.stderr.count(alone.stderr), 1, together.stderr)
        self.assertEqual(together.stderr.count("camber: "), 1, together.stderr)

    def test_commands_without_block_support_are_rejected(self):
        run = self.on_ranks(2, "check", "shell.meshb", "--vtu", "shell.vtu")
        self.assertEqual(run.returncode, 2)
        self.assertIn("camber: check: cannot run on several ranks", run.stderr)
        self.assertFalse((self.folder / "shell.vtu").exists())

    def test_one_rank_writes_the_same_mesh_as_the_serial_program(self):
        self.camber("generate", "shell", "-o", "shell.meshb")
        self.camber("curve", "shell.meshb", "-o", "alone.meshb")
        self.assertEqual(self.on_ranks(1, "curve", "shell.meshb", "-o", "one.meshb").returncode, 0)
        alone, one = (self.folder / name for name in ("alone.meshb", "one.meshb"))
        self.assertEqual(alone.read_bytes(), one.read_bytes())


if __name__ == "__main__":
    main()
