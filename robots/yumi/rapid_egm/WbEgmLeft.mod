MODULE WbEgmLeft
    ! The left arm; loaded into T_ROB_L beside WbEgm.

    CONST string my_name:="left";

    ! Names of UDPUC devices: to the workbench's port, and its port for states.
    CONST string my_device:="WbLeft";
    CONST string my_states:="WbLeftStates";

    PROC main()
        wb_obey;
    ENDPROC

    PROC wb_join(INOUT egmident id,string device)
        EGMSetupUC ROB_L,id,"default",device\Joint\CommTimeout:=WB_SILENCE;
    ENDPROC
ENDMODULE
