# Files of a wheel, relative to the package's folder; setup.py installs this component.
if(TARGET python_module)
  install(TARGETS lichtenberg RUNTIME DESTINATION bin COMPONENT wheel EXCLUDE_FROM_ALL)
  install(TARGETS python_module DESTINATION . COMPONENT wheel EXCLUDE_FROM_ALL)
  install(DIRECTORY python/lichtenberg/ DESTINATION . COMPONENT wheel EXCLUDE_FROM_ALL PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY scenes DESTINATION . COMPONENT wheel EXCLUDE_FROM_ALL)
  install(DIRECTORY solvers src DESTINATION include COMPONENT wheel EXCLUDE_FROM_ALL
    FILES_MATCHING PATTERN "*.hpp" PATTERN commands EXCLUDE)
endif()
