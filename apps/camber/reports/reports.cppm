/// Reports of runs and of meshes as texts, pictures and pages.
export module camber.reports;
export import :inspection;
export import :page;
export import :texts;
