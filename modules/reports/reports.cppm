/// Reports of runs and of meshes as texts, pictures and pages.
export module camber.reports;
export import :page;
export import :picture;
export import :texts;
